/* SPDX-License-Identifier: MIT
 *
 * The names of mistakes, and the set that a thread makes.
 */
#include "brdf/core/mistakes.h"

_Thread_local nqm_mistakes nqm_mistakes_made;

#define WORDS_OF(NAME, WORDS) WORDS,
static const char *const words[] = {NQM_MISTAKES(WORDS_OF)};

const char *nqm_mistake_words(size_t mistake) {
    return words[mistake];
}
