/* SPDX-License-Identifier: MIT
 *
 * The matrix product of oneDNN in its fastest form, for comparison: the primitive is created in advance, and the
 * weights have the layout that it prefers. Without oneDNN (NQM_ONEDNN) there is no comparison.
 */
#include "bench/bench.h"

#ifdef NQM_ONEDNN
#include <dnnl.h>

struct nqm_bench_onednn {
    dnnl_engine_t engine;
    dnnl_stream_t stream;
    dnnl_primitive_t primitive;
    dnnl_memory_t memory[3]; /* A, B, C */
    void *block[3];
};

/* Bytes of a small positive number in each precision. */
static const unsigned char pattern[][4] = {{0, 0, 0, 0x3c}, {0, 0x3c, 0, 0x3c}};

static bool init_matrix(dnnl_memory_desc_t *desc, size_t rows, size_t columns, dnnl_data_type_t type,
                        dnnl_format_tag_t tag) {
    const dnnl_dims_t dims = {(dnnl_dim_t)rows, (dnnl_dim_t)columns};
    return dnnl_memory_desc_init_by_tag(desc, 2, dims, type, tag) == dnnl_success;
}

static bool make_primitive(nqm_bench_onednn *p, dnnl_matmul_desc_t *op, nqm_precision precision) {
    dnnl_primitive_desc_t desc;
    if (dnnl_primitive_desc_create(&desc, op, NULL, p->engine, NULL) != dnnl_success)
        return false;
    static const dnnl_query_t queries[] = {dnnl_query_src_md, dnnl_query_weights_md, dnnl_query_dst_md};
    bool ok = dnnl_primitive_create(&p->primitive, desc) == dnnl_success;
    for (size_t i = 0; i < 3 && ok; ++i) {
        const dnnl_memory_desc_t *md = dnnl_primitive_desc_query_md(desc, queries[i], 0);
        size_t n_bytes = dnnl_memory_desc_get_size(md);
        unsigned char *block = p->block[i] = nqm_alloc(n_bytes, 1);
        for (size_t byte = 0; block && byte < n_bytes; ++byte)
            block[byte] = pattern[precision][byte % 4];
        ok = block && dnnl_memory_create(&p->memory[i], md, p->engine, block) == dnnl_success;
    }
    dnnl_primitive_desc_destroy(desc);
    return ok;
}

static bool make_product(nqm_bench_onednn *p, nqm_precision precision, bool trans_a, size_t m, size_t n, size_t k) {
    const dnnl_data_type_t type = precision == NQM_PRECISION_BF16 ? dnnl_bf16 : dnnl_f32;
    dnnl_memory_desc_t a, b, c;
    dnnl_matmul_desc_t op;
    return dnnl_engine_create(&p->engine, dnnl_cpu, 0) == dnnl_success &&
           dnnl_stream_create(&p->stream, p->engine, dnnl_stream_default_flags) == dnnl_success &&
           init_matrix(&a, m, k, type, trans_a ? dnnl_ba : dnnl_ab) &&
           init_matrix(&b, k, n, type, trans_a ? dnnl_ab : dnnl_format_tag_any) &&
           init_matrix(&c, m, n, dnnl_f32, dnnl_ab) && dnnl_matmul_desc_init(&op, &a, &b, NULL, &c) == dnnl_success &&
           make_primitive(p, &op, precision);
}

nqm_bench_onednn *nqm_bench_onednn_create(nqm_precision precision, bool trans_a, size_t m, size_t n, size_t k) {
    nqm_bench_onednn *p = nqm_alloc(1, sizeof *p);
    if (p && make_product(p, precision, trans_a, m, n, k))
        return p;
    nqm_bench_onednn_free(p);
    return NULL;
}

void nqm_bench_onednn_run(void *product) {
    const nqm_bench_onednn *p = product;
    const dnnl_exec_arg_t arguments[] = {
        {DNNL_ARG_SRC, p->memory[0]}, {DNNL_ARG_WEIGHTS, p->memory[1]}, {DNNL_ARG_DST, p->memory[2]}};
    dnnl_primitive_execute(p->primitive, p->stream, 3, arguments);
    dnnl_stream_wait(p->stream);
}

void nqm_bench_onednn_free(nqm_bench_onednn *p) {
    if (!p)
        return;
    for (size_t i = 0; i < 3; ++i) {
        dnnl_memory_destroy(p->memory[i]);
        nqm_free(p->block[i]);
    }
    dnnl_primitive_destroy(p->primitive);
    dnnl_stream_destroy(p->stream);
    dnnl_engine_destroy(p->engine);
    nqm_free(p);
}
#else /* built without oneDNN */
nqm_bench_onednn *nqm_bench_onednn_create(nqm_precision precision, bool trans_a, size_t m, size_t n, size_t k) {
    (void)precision, (void)trans_a, (void)m, (void)n, (void)k;
    return NULL;
}

void nqm_bench_onednn_run(void *product) {
    (void)product;
}

void nqm_bench_onednn_free(nqm_bench_onednn *p) {
    (void)p;
}
#endif
