/* SPDX-License-Identifier: MIT
 *
 * The text of a loss: "auto", "auto:SUM" or SUM, where SUM is "WEIGHT*WORD+...".
 */
#include "fit/fit.h"

/* Chosen on ten measured materials that no test uses (doc/fitting.md): the term of values keeps the fit from what one set of
 * lights does not see. */
const char *const nqm_match_polish = "100*ma_crwe+transport";

static bool is_word(const char *text, size_t n, const char *word) {
    return strlen(word) == n && strncmp(text, word, n) == 0;
}

static nqm_status fail_unknown(const char *word, size_t n, nqm_error *err) {
    char words[300], wrong[41];
    size_t used = 0;
    snprintf(wrong, sizeof wrong, "%.*s", (int)nqm_smaller(n, 40), word);
    nqm_nearest nearest = nqm_nearest_begin(strcmp(wrong, "jod") == 0 ? "nqm" : wrong); /* nqm is the loss of JOD */
    nqm_nearest_add(&nearest, "auto");
    nqm_nearest_add(&nearest, "nqm");
    nqm_nearest_add(&nearest, "transport");
    for (size_t i = 0; nqm_fit_loss_words[i]; ++i) {
        used += (size_t)snprintf(words + used, sizeof words - used, ", %s", nqm_fit_loss_words[i]);
        nqm_nearest_add(&nearest, nqm_fit_loss_words[i]);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "there is no loss '%s'%s; there are auto, nqm, transport%s", wrong,
                    nearest.advice, words);
}

static nqm_status parse_word(const char *word, size_t n, nqm_match_term *term, nqm_error *err) {
    if (is_word(word, n, "nqm"))
        term->kind = NQM_MATCH_METRIC;
    else if (is_word(word, n, "transport"))
        term->kind = NQM_MATCH_TRANSPORT;
    else {
        size_t i = 0;
        while (nqm_fit_loss_words[i] && !is_word(word, n, nqm_fit_loss_words[i]))
            ++i;
        if (!nqm_fit_loss_words[i])
            return fail_unknown(word, n, err);
        term->kind = NQM_MATCH_VALUES;
        term->loss = (nqm_fit_loss)i;
    }
    return NQM_OK;
}

/* "WEIGHT*WORD" or "WORD". */
static nqm_status parse_term(const char *text, const char **end, nqm_match_term *term, nqm_error *err) {
    const char *word = text;
    term->weight = 1;
    if (nqm_parse_double(text, &word, &term->weight)) {
        if (*word != '*' || !(term->weight > 0))
            return nqm_fail(err, NQM_ERR_ARG, -1,
                            "a term of a loss is WORD or WEIGHT*WORD with a weight > 0, not '%.40s'", text);
        ++word;
    }
    size_t n = strcspn(word, "+");
    *end = word + n;
    return parse_word(word, n, term, err);
}

nqm_status nqm_match_parse(const char *text, nqm_match_sum *sum, nqm_error *err) {
    *sum = (nqm_match_sum){.is_auto = is_word(text, strcspn(text, ":"), "auto")};
    if (sum->is_auto)
        text = text[4] ? text + 5 : nqm_match_polish;
    for (;; ++text) {
        if (sum->n == NQM_MATCH_MAX_TERMS)
            return nqm_fail(err, NQM_ERR_ARG, -1, "a loss has at most %d terms", NQM_MATCH_MAX_TERMS);
        nqm_status status = parse_term(text, &text, &sum->terms[sum->n++], err);
        if (status != NQM_OK || !*text)
            return status;
    }
}
