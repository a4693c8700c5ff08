/* SPDX-License-Identifier: MIT
 *
 * The kernels by tile registers (kernel/amx_products.h) over their emulation: the instructions by hand-computed values;
 * products and weight gradients of every tail against the plain loops, with buffers that end at an unreadable page; the
 * same bits however a product is cut and for any number of threads; the caller's tile configuration after a call. Then
 * the same of the processor's own instructions, if it has them.
 */
#include "kernel/panel.h"
#include "support/amx_emulated.h"
#include "support/check.h"
#include "support/tables.h"

#include <math.h>
#include <omp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

static const uint64_t seed = 41;

/* ---- the instructions --------------------------------------------------------------------------------------------- */

typedef struct shapes {
    uint8_t palette, unused[15];
    uint16_t row_bytes[16];
    uint8_t rows[16];
} shapes;

/* Registers 0 (rows, words) += 1 (rows, depth) 2 (depth, words). */
static shapes shapes_of(uint8_t rows, uint8_t depth, uint8_t words) {
    return (shapes){.palette = 1,
                    .row_bytes = {(uint16_t)(4 * words), (uint16_t)(4 * depth), (uint16_t)(4 * words)},
                    .rows = {rows, rows, depth}};
}

static uint32_t two(float low, float high) {
    return nqm_bf16_bits(low) | nqm_bf16_bits(high) << 16;
}

/* c + a b for rows of `depth` words. */
static float dot(uint8_t depth, float c, const uint32_t *a, const uint32_t *b) {
    const shapes s = shapes_of(1, depth, 1);
    amx_configure(&s);
    amx_load(0, &c, 4);
    amx_load(1, a, 64);
    amx_load(2, b, 4);
    amx_bf16(0, 1, 2);
    amx_store(0, &c, 4);
    amx_configure(&(shapes){.palette = 0});
    return c;
}

static void sums_of_bfloat16(void **state) {
    (void)state;
    const uint32_t ones[3] = {two(1, 1), two(1, 1), two(1, 1)};
    assert_true(dot(1, 0.5f, (uint32_t[]){two(3, -2)}, (uint32_t[]){two(5, 7)}) == 1.5f);
    /* The sum of lower halves is 2^24 + 1 - 2^24, which rounds to 0; that of upper halves is 1. */
    const uint32_t mixed[3] = {two(0x1p24f, 1), two(1, 0), two(-0x1p24f, 0)};
    assert_true(dot(3, 0, mixed, ones) == 1);
    /* One chain from c on would give 2^24 each time. */
    assert_true(dot(3, 0x1p24f, ones, ones) == 0x1p24f + 6);
    /* Denormal factors, sums and results are 0. */
    assert_true(dot(1, 0, (uint32_t[]){0x00400040}, (uint32_t[]){two(0x1p100f, 0x1p100f)}) == 0);
    assert_true(dot(1, 0, (uint32_t[]){two(0x1p-63f, 0)}, (uint32_t[]){two(0x1p-64f, 0)}) == 0);
    assert_true(dot(1, 0, (uint32_t[]){two(0x1p-63f, 0)}, (uint32_t[]){two(0x1p-63f, 0)}) == 0x1p-126f);
    assert_true(dot(1, 0x1p-127f, (uint32_t[]){0}, ones) == 0);
    /* 2^-126 (1 - 2^-24) is denormal although its float neighbour is 2^-126, and 2^-126 (1 - 2^-25) rounds to 2^-126. */
    const uint32_t minus[2] = {two(0x1p-63f, 0), two(-0x1p-75f, 0)};
    assert_true(dot(2, 0, minus, (uint32_t[]){two(0x1p-63f, 0), two(0x1p-75f, 0)}) == 0);
    assert_true(dot(2, 0, minus, (uint32_t[]){two(0x1p-63f, 0), two(0x1p-76f, 0)}) == 0x1p-126f);
    assert_true(isinf(dot(1, INFINITY, ones, ones)) && isnan(dot(1, NAN, ones, ones)));
}

static void sums_of_bytes(void **state) {
    (void)state;
    const shapes s = shapes_of(2, 1, 2);
    const uint32_t a[2] = {0xff01ff02, 3}, b[2] = {0x80017f01, 0xfffffffe};
    int32_t c[4] = {0, INT32_MAX, 10, 20};
    amx_configure(&s);
    amx_load(0, c, 8);
    amx_load(1, a, 4);
    amx_load(2, b, 8);
    amx_int8(0, 1, 2);
    amx_store(0, c, 8);
    amx_configure(&(shapes){.palette = 0});
    assert_int_equal(c[0], 2 * 1 + 255 * 127 + 1 * 1 - 255 * 128);
    assert_int_equal((uint32_t)c[1], (uint32_t)INT32_MAX - 2 * 2 - 255 - 1 - 255);
    assert_int_equal(c[2], 10 + 3);
    assert_int_equal(c[3], 20 - 6);
}

/* Rows and words beyond the shape are 0 after a load, and are not stored. */
static void registers_are_cut(void **state) {
    (void)state;
    float from[4][3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}, to[4][3] = {{0}};
    const float expected[4][3] = {{1, 2}, {4, 5}, {7, 8}};
    const shapes s = {.palette = 1, .row_bytes = {8}, .rows = {3}};
    shapes back;
    amx_configure(&s);
    amx_configuration(&back);
    assert_memory_equal(&back, &s, sizeof s);
    amx_load(0, from, sizeof *from);
    amx_store(0, to, sizeof *to);
    assert_memory_equal(to, expected, sizeof to);
    amx_configure(&s); /* clears */
    amx_store(0, to, sizeof *to);
    assert_true(to[0][0] == 0 && to[2][1] == 0);
    amx_configure(&(shapes){.palette = 0});
}

typedef enum misuse {
    UNCONFIGURED,
    TOO_WIDE,
    TOO_HIGH,
    NO_ROWS,
    PALETTE_2,
    EMPTY_REGISTER,
    NINTH_REGISTER,
    OTHER_DEPTH,
    SAME_REGISTER,
    N_MISUSES
} misuse;

static void do_wrong(misuse what) {
    uint32_t words[256] = {0};
    shapes s = shapes_of(16, 16, 16);
    s.row_bytes[0] = what == TOO_WIDE ? 68 : 64;
    s.rows[0] = what == TOO_HIGH ? 17 : what == NO_ROWS ? 0 : 16;
    s.rows[2] = what == OTHER_DEPTH ? 15 : 16;
    s.palette = what == PALETTE_2 ? 2 : 1;
    if (what != UNCONFIGURED)
        amx_configure(&s);
    if (what == EMPTY_REGISTER || what == NINTH_REGISTER)
        amx_load(what == NINTH_REGISTER ? 8 : 3, words, 64);
    else if (what == SAME_REGISTER)
        amx_int8(1, 1, 2);
    else
        amx_bf16(0, 1, 2);
}

static void misuse_is_refused(void **state) {
    (void)state;
    for (misuse what = UNCONFIGURED; what <= N_MISUSES; ++what) { /* the last one is no misuse */
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            signal(SIGABRT, SIG_DFL); /* not cmocka's */
            if (!freopen("/dev/null", "w", stderr))
                _exit(2);
            do_wrong(what);
            _exit(0);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(what == N_MISUSES ? WIFEXITED(status) && WEXITSTATUS(status) == 0
                                      : WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
    }
}

/* ---- buffers ------------------------------------------------------------------------------------------------------ */

/* n words that end where the next page is unreadable. */
typedef struct guarded {
    uint32_t *at;
    char *pages;
    size_t n_bytes;
} guarded;

static guarded guard(size_t n) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE), n_bytes = nqm_ceil_div(n * sizeof(uint32_t), page) * page;
    guarded g = {.n_bytes = n_bytes + page};
    g.pages = mmap(NULL, g.n_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(g.pages != MAP_FAILED);
    assert_int_equal(mprotect(g.pages + n_bytes, page, PROT_NONE), 0);
    g.at = (uint32_t *)(void *)(g.pages + n_bytes) - n;
    return g;
}

static void drop(guarded *g) {
    munmap(g->pages, g->n_bytes);
}

/* The bits of random bytes that may be 1. */
static uint32_t byte_bits;

static guarded random_words(nqm_rng *rng, nqm_precision precision, size_t n) {
    guarded g = guard(n);
    for (size_t i = 0; i < n; ++i)
        g.at[i] = precision == NQM_PRECISION_BF16 ? two((float)nqm_rng_normal(rng), (float)nqm_rng_normal(rng))
                                                  : (uint32_t)(nqm_rng_uniform(rng) * 0x1p32) & byte_bits;
    return g;
}

/* Values of C: floats, or integers whose sums do not overflow. */
static guarded random_sums(nqm_rng *rng, nqm_precision precision, size_t n) {
    guarded g = guard(n);
    for (size_t i = 0; i < n; ++i) {
        const float value = (float)nqm_rng_normal(rng);
        const int32_t integer = (int32_t)(1000 * value);
        memcpy(&g.at[i], precision == NQM_PRECISION_INT8 ? (const void *)&integer : &value, sizeof *g.at);
    }
    return g;
}

static const nqm_precision precisions[] = {NQM_PRECISION_BF16, NQM_PRECISION_INT8};

/* States of tests: with numbers of this kind. Signs do not matter to small bytes. */
typedef struct numbers {
    nqm_precision precision;
    uint32_t byte_bits;
} numbers;

static numbers bfloats = {NQM_PRECISION_BF16, 0}, bytes = {NQM_PRECISION_INT8, 0xffffffff},
               small_bytes = {NQM_PRECISION_INT8, 0x7f7f7f7f};

static nqm_precision take_numbers(void **state) {
    const numbers *n = *state;
    byte_bits = n->byte_bits;
    return n->precision;
}

/* Those over the emulation, or of the processor; NULL: it has none. */
static const nqm_kernels *under_test;

/* The largest difference of sums of 2 `words` products with standard deviations of 1: 10 of these, rounded once for each. */
static double tolerance(size_t words) {
    return 10 * sqrt(2 * (double)words + 1) * (double)(2 * words + 2) * 0x1p-24;
}

static void check_sums(nqm_precision precision, size_t n, size_t words, const uint32_t *actual,
                       const uint32_t *expected) {
    if (precision == NQM_PRECISION_INT8) {
        assert_memory_equal(actual, expected, n * sizeof *actual);
        return;
    }
    float a[NQM_STRIP * NQM_PANEL], e[NQM_STRIP * NQM_PANEL];
    memcpy(a, actual, n * sizeof *a);
    memcpy(e, expected, n * sizeof *e);
    for (size_t i = 0; i < n; ++i)
        assert_near((double)a[i], (double)e[i], tolerance(words));
}

/* ---- products ----------------------------------------------------------------------------------------------------- */

enum { MOST_ROWS = 40, GAP = 3 };

/* C (m, NQM_PANEL) of one panel; rows of C have GAP words more, which must be kept. */
static void check_product(nqm_rng *rng, nqm_precision precision, size_t m, size_t words) {
    const size_t lda = words + (m % 2) * GAP, ldc = NQM_PANEL + GAP;
    guarded a = random_words(rng, precision, (m - 1) * lda + words),
            b = random_words(rng, precision, words * NQM_PANEL),
            before = random_sums(rng, precision, (m - 1) * ldc + NQM_PANEL), c = guard((m - 1) * ldc + NQM_PANEL);
    for (int add = 0; add < 2; ++add) {
        nqm_product p = {
            .m = m, .words = words, .n_panels = 1, .add = add, .a = a.at, .b = b.at, .c = c.at, .lda = lda, .ldc = ldc};
        const size_t n_bytes = ((m - 1) * ldc + NQM_PANEL) * sizeof *c.at;
        memcpy(c.at, before.at, n_bytes);
        under_test->product[precision](&p);
        for (size_t i = 0; i < m; ++i) {
            uint32_t row[NQM_PANEL], one[NQM_PANEL];
            memcpy(row, before.at + i * ldc, sizeof row);
            memcpy(one, row, sizeof one);
            nqm_product of_row = {
                .m = 1, .words = words, .n_panels = 1, .add = add, .a = a.at + i * lda, .b = b.at, .c = row};
            nqm_kernels_scalar.product[precision](&of_row);
            check_sums(precision, NQM_PANEL, words, c.at + i * ldc, row);
            of_row.c = one; /* the same bits from a row alone */
            under_test->product[precision](&of_row);
            assert_memory_equal(c.at + i * ldc, one, sizeof one);
            if (i + 1 < m)
                assert_memory_equal(c.at + i * ldc + NQM_PANEL, before.at + i * ldc + NQM_PANEL, GAP * sizeof *c.at);
        }
    }
    drop(&a), drop(&b), drop(&before), drop(&c);
}

static void products_with_tails(void **state) {
    const nqm_precision precision = take_numbers(state);
    nqm_rng rng = nqm_rng_make(seed, 0);
    static const size_t some_words[] = {1, 15, 16, 17, 37}, some_rows[] = {1, 16, 33};
    for (size_t m = 1; m <= MOST_ROWS; ++m)
        for (size_t w = 0; w < 5; ++w)
            check_product(&rng, precision, m, some_words[w]);
    for (size_t words = 1; words <= 70; ++words)
        for (size_t i = 0; i < 3; ++i)
            check_product(&rng, precision, some_rows[i], words);
}

/* Rows times n panels: the bits of a product with each panel. */
static void check_panels(nqm_rng *rng, nqm_precision precision, size_t m, size_t n_panels, size_t words) {
    enum { MOST = 3 };
    const size_t step = nqm_ceil_div(words, NQM_STRIP) * NQM_STRIP * NQM_PANEL, ldc = n_panels * NQM_PANEL;
    guarded a = random_words(rng, precision, m * words),
            b = random_words(rng, precision, (n_panels - 1) * step + words * NQM_PANEL),
            c = random_sums(rng, precision, m * ldc);
    for (int add = 0; add < 2; ++add) {
        uint32_t expected[MOST * MOST * NQM_PANEL];
        memcpy(expected, c.at, m * ldc * sizeof *c.at);
        nqm_product p = {.m = m, .words = words, .n_panels = 1, .add = add, .a = a.at, .lda = words, .ldc = ldc};
        for (size_t i = 0; i < n_panels; ++i) {
            p.b = b.at + i * step, p.c = expected + i * NQM_PANEL;
            under_test->product[precision](&p);
        }
        p.n_panels = n_panels, p.panel_step = step, p.b = b.at, p.c = c.at;
        under_test->product[precision](&p);
        assert_memory_equal(c.at, expected, m * ldc * sizeof *c.at);
    }
    drop(&a), drop(&b), drop(&c);
}

static void several_panels(void **state) {
    const nqm_precision precision = take_numbers(state);
    nqm_rng rng = nqm_rng_make(seed, 1);
    for (size_t words = 1; words <= 70; ++words)
        for (size_t n_panels = 1; n_panels <= 3; ++n_panels)
            check_panels(&rng, precision, 1 + words % 3, n_panels, words);
}

/* A sum that is continued after a multiple of 16 words has the bits of one sum. */
static void continued_sums(void **state) {
    (void)state;
    enum { M = 21, WORDS = 53 };
    nqm_rng rng = nqm_rng_make(seed, 2);
    guarded a = random_words(&rng, NQM_PRECISION_BF16, M * WORDS),
            b = random_words(&rng, NQM_PRECISION_BF16, WORDS * NQM_PANEL);
    float whole[M * NQM_PANEL], cut[M * NQM_PANEL];
    nqm_product p = {
        .m = M, .words = WORDS, .n_panels = 1, .a = a.at, .b = b.at, .c = whole, .lda = WORDS, .ldc = NQM_PANEL};
    under_test->product[NQM_PRECISION_BF16](&p);
    for (size_t at = 16; at < WORDS; at += 16) {
        p.add = false, p.words = at, p.a = a.at, p.b = b.at, p.c = cut;
        under_test->product[NQM_PRECISION_BF16](&p);
        p.add = true, p.words = WORDS - at, p.a = a.at + at, p.b = b.at + at * NQM_PANEL;
        under_test->product[NQM_PRECISION_BF16](&p);
        assert_memory_equal(cut, whole, sizeof whole);
    }
    drop(&a), drop(&b);
}

static void any_number_of_threads(void **state) {
    (void)state;
    enum { M = 301, K = 205, N = 70, WORDS = (K + 1) / 2, LDC = 3 * NQM_PANEL };
    const int threads = omp_get_max_threads();
    nqm_rng rng = nqm_rng_make(seed, 3);
    static float w[N * K], one[M * LDC], c[M * LDC];
    guarded a = random_words(&rng, NQM_PRECISION_BF16, M * WORDS);
    nqm_panels b;
    for (size_t i = 0; i < N * K; ++i)
        w[i] = (float)nqm_rng_normal(&rng);
    assert_int_equal(nqm_panels_create(NQM_PRECISION_BF16, K, N, &b, NULL), NQM_OK);
    nqm_panels_pack(&b, (nqm_weights){w, NULL, K});
    nqm_kernels_use(under_test);
    for (int n = 1; n <= 4; ++n) {
        omp_set_num_threads(n);
        nqm_multiply(&b, M, a.at, WORDS, false, n == 1 ? one : c, LDC);
        assert_true(n == 1 || memcmp(c, one, sizeof c) == 0);
        int n_configured = 0;
#pragma omp parallel reduction(+ : n_configured)
        {
            shapes left;
            amx_configuration(&left);
            n_configured += left.palette;
        }
        assert_int_equal(n_configured, 0);
    }
    use_chosen_kernels();
    omp_set_num_threads(threads);
    nqm_panels_free(&b);
    drop(&a);
}

/* ---- weight gradients --------------------------------------------------------------------------------------------- */

static void check_gradient(nqm_rng *rng, size_t n_strips, size_t words) {
    enum { TILE = NQM_STRIP * NQM_PANEL };
    const size_t step = words * NQM_STRIP;
    guarded left = random_words(rng, NQM_PRECISION_BF16, n_strips * step),
            right = random_words(rng, NQM_PRECISION_BF16, words * NQM_PANEL), c = guard(n_strips * TILE),
            one = guard(TILE);
    float *const to = (float *)(void *)c.at, *const to_one = (float *)(void *)one.at;
    nqm_tile_gradient g = {.n_strips = n_strips,
                           .words = words,
                           .left = left.at,
                           .right = right.at,
                           .step = step,
                           .c = to,
                           .prefetch = {to, to, to}};
    under_test->gradient[NQM_PRECISION_BF16](&g);
    g.n_strips = 1, g.c = to_one;
    for (size_t s = 0; s < n_strips; ++s) {
        g.left = left.at + s * step;
        nqm_kernels_scalar.gradient[NQM_PRECISION_BF16](&g);
        check_sums(NQM_PRECISION_BF16, TILE, words, c.at + s * TILE, one.at);
        under_test->gradient[NQM_PRECISION_BF16](&g);
        assert_memory_equal(c.at + s * TILE, one.at, TILE * sizeof *one.at);
    }
    drop(&left), drop(&right), drop(&c), drop(&one);
}

static void gradients_with_tails(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(seed, 4);
    static const size_t long_ones[] = {255, 256, 257, 272, 530};
    for (size_t words = 1; words <= 70; ++words)
        check_gradient(&rng, 1 + words % 3, words);
    for (size_t i = 0; i < sizeof long_ones / sizeof *long_ones; ++i)
        check_gradient(&rng, 2, long_ones[i]);
}

/* ---- the caller's registers --------------------------------------------------------------------------------------- */

static void configuration_is_restored(void **state) {
    (void)state;
    enum { WORDS = 19 };
    nqm_rng rng = nqm_rng_make(seed, 5);
    guarded a = random_words(&rng, NQM_PRECISION_BF16, WORDS * NQM_PANEL), c = guard(NQM_PANEL * NQM_PANEL);
    float *const to = (float *)(void *)c.at;
    const shapes callers[] = {shapes_of(5, 7, 9), {.palette = 0}};
    for (size_t i = 0; i < 2; ++i)
        for (int kernel = 0; kernel < 3; ++kernel) {
            shapes after;
            amx_configure(&callers[i]);
            if (kernel < 2)
                under_test->product[precisions[kernel]](&(nqm_product){.m = 18,
                                                                       .words = WORDS,
                                                                       .n_panels = 1,
                                                                       .a = a.at,
                                                                       .b = a.at,
                                                                       .c = c.at,
                                                                       .lda = WORDS,
                                                                       .ldc = NQM_PANEL});
            else
                under_test->gradient[NQM_PRECISION_BF16](&(nqm_tile_gradient){
                    .n_strips = 1, .words = WORDS, .left = a.at, .right = a.at, .c = to, .prefetch = {to, to, to}});
            amx_configuration(&after);
            assert_memory_equal(&after, &callers[i], sizeof after);
        }
    drop(&a), drop(&c);
}

/* ---- the processor ------------------------------------------------------------------------------------------------ */

static const nqm_kernels *kernels_of_processor(void) {
    size_t t = 0;
    while (nqm_kernels_at(t) && strcmp(nqm_kernels_at(t)->name, "avx512+amx") != 0)
        ++t;
    return nqm_kernels_at(t);
}

static void the_processor_has_none(void **state) {
    (void)state;
    skip();
}

int main(void) {
    printf("seed %llu\n", (unsigned long long)seed);
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(sums_of_bfloat16),
        cmocka_unit_test(sums_of_bytes),
        cmocka_unit_test(registers_are_cut),
        cmocka_unit_test(misuse_is_refused),
        cmocka_unit_test_prestate(products_with_tails, &bfloats),
        cmocka_unit_test_prestate(products_with_tails, &bytes),
        cmocka_unit_test_prestate(several_panels, &bfloats),
        cmocka_unit_test_prestate(several_panels, &bytes),
        cmocka_unit_test(continued_sums),
        cmocka_unit_test(any_number_of_threads),
        cmocka_unit_test(gradients_with_tails),
        cmocka_unit_test(configuration_is_restored),
    };
    const struct CMUnitTest own[] = {
        {"bf16_products_of_the_processor", products_with_tails, NULL, NULL, &bfloats},
        {"bf16_rows_of_the_processor", several_panels, NULL, NULL, &bfloats},
        {"continued_sums_of_the_processor", continued_sums, NULL, NULL, NULL},
        {"bf16_gradients_of_the_processor", gradients_with_tails, NULL, NULL, NULL},
        {"threads_of_the_processor", any_number_of_threads, NULL, NULL, NULL},
        {"small_int8_products_of_the_processor", products_with_tails, NULL, NULL, &small_bytes},
        {"int8_products_of_the_processor", products_with_tails, NULL, NULL, &bytes},
        {"int8_rows_of_the_processor", several_panels, NULL, NULL, &bytes},
    };
    const struct CMUnitTest none[] = {cmocka_unit_test(the_processor_has_none)};
    under_test = emulated_kernels();
    const int failed = cmocka_run_group_tests(emulated, NULL, NULL);
    under_test = kernels_of_processor();
    return failed + (under_test ? cmocka_run_group_tests(own, NULL, NULL) : cmocka_run_group_tests(none, NULL, NULL));
}
