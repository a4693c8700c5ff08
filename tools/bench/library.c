/* SPDX-License-Identifier: MIT
 *
 * The matrix product of oneDNN as a program that cares would use it: its primitive made beforehand, and weights in the
 * layout that it chose. What our products are compared with.
 */
#include "bench/inside.h"
#include "kernel/onednn.h"

struct nqm_library_product {
    const nqm_onednn *onednn;
    dnnl_engine_t engine;
    dnnl_stream_t stream;
    dnnl_primitive_t primitive;
    dnnl_memory_t memory[3]; /* A, B, C */
    void *block[3];
};

/* A pattern of bytes that is a small positive number in every precision. */
static const unsigned char pattern[NQM_PRECISION_COUNT][4] = {{0, 0, 0, 0x3c}, {0, 0x3c, 0, 0x3c}, {1, 1, 1, 1}};

static bool init_matrix(const nqm_library_product *p, dnnl_memory_desc_t *desc, size_t rows, size_t columns,
                        dnnl_data_type_t type, dnnl_format_tag_t tag) {
    const dnnl_dims_t dims = {(dnnl_dim_t)rows, (dnnl_dim_t)columns};
    return p->onednn->dnnl_memory_desc_init_by_tag(desc, 2, dims, type, tag) == dnnl_success;
}

static bool make_primitive(nqm_library_product *p, dnnl_matmul_desc_t *op, nqm_precision precision, bool *no_memory) {
    dnnl_primitive_desc_t desc;
    if (p->onednn->dnnl_primitive_desc_create(&desc, op, NULL, p->engine, NULL) != dnnl_success)
        return false;
    static const dnnl_query_t queries[] = {dnnl_query_src_md, dnnl_query_weights_md, dnnl_query_dst_md};
    bool ok = p->onednn->dnnl_primitive_create(&p->primitive, desc) == dnnl_success;
    for (size_t i = 0; i < 3 && ok; ++i) {
        const dnnl_memory_desc_t *md = p->onednn->dnnl_primitive_desc_query_md(desc, queries[i], 0);
        size_t n_bytes = p->onednn->dnnl_memory_desc_get_size(md);
        unsigned char *block = p->block[i] = nqm_alloc(n_bytes, 1);
        *no_memory = *no_memory || !block;
        for (size_t byte = 0; block && byte < n_bytes; ++byte)
            block[byte] = pattern[precision][byte % 4];
        ok = block && p->onednn->dnnl_memory_create(&p->memory[i], md, p->engine, block) == dnnl_success;
    }
    p->onednn->dnnl_primitive_desc_destroy(desc);
    return ok;
}

static bool make_product(nqm_library_product *p, nqm_precision precision, bool trans_a, const nqm_library_shape *s,
                         bool *no_memory) {
    static const dnnl_data_type_t left[] = {dnnl_f32, dnnl_bf16, dnnl_u8}, right[] = {dnnl_f32, dnnl_bf16, dnnl_s8},
                                  out[] = {dnnl_f32, dnnl_f32, dnnl_s32};
    dnnl_memory_desc_t a, b, c;
    dnnl_matmul_desc_t op;
    return p->onednn->dnnl_engine_create(&p->engine, dnnl_cpu, 0) == dnnl_success &&
           p->onednn->dnnl_stream_create(&p->stream, p->engine, dnnl_stream_default_flags) == dnnl_success &&
           init_matrix(p, &a, s->m, s->k, left[precision], trans_a ? dnnl_ba : dnnl_ab) &&
           init_matrix(p, &b, s->k, s->n, right[precision], trans_a ? dnnl_ab : dnnl_format_tag_any) &&
           init_matrix(p, &c, s->m, s->n, out[precision], dnnl_ab) &&
           p->onednn->dnnl_matmul_desc_init(&op, &a, &b, NULL, &c) == dnnl_success &&
           make_primitive(p, &op, precision, no_memory);
}

nqm_status nqm_library_product_create(nqm_precision precision, bool trans_a, const nqm_library_shape *shape,
                                      nqm_library_product **product_ret, nqm_error *err) {
    const nqm_onednn *onednn = nqm_onednn_get();
    bool no_memory = false;
    *product_ret = NULL;
    if (!onednn)
        return NQM_OK;
    nqm_library_product *p = *product_ret = nqm_alloc(1, sizeof *p);
    if (!p)
        return nqm_fail_nomem(err, sizeof *p);
    p->onednn = onednn;
    if (make_product(p, precision, trans_a, shape, &no_memory))
        return NQM_OK;
    nqm_library_product_free(p);
    *product_ret = NULL;
    return no_memory ? nqm_fail_nomem(err, shape->k * shape->n * sizeof(float)) : NQM_OK;
}

void nqm_library_product_run(void *product) {
    const nqm_library_product *p = product;
    const dnnl_exec_arg_t arguments[] = {
        {DNNL_ARG_SRC, p->memory[0]}, {DNNL_ARG_WEIGHTS, p->memory[1]}, {DNNL_ARG_DST, p->memory[2]}};
    p->onednn->dnnl_primitive_execute(p->primitive, p->stream, 3, arguments);
    p->onednn->dnnl_stream_wait(p->stream);
}

void nqm_library_product_free(nqm_library_product *p) {
    if (!p)
        return;
    for (size_t i = 0; i < 3; ++i) {
        p->onednn->dnnl_memory_destroy(p->memory[i]);
        nqm_free(p->block[i]);
    }
    p->onednn->dnnl_primitive_destroy(p->primitive);
    p->onednn->dnnl_stream_destroy(p->stream);
    p->onednn->dnnl_engine_destroy(p->engine);
    nqm_free(p);
}

void nqm_library_sgemm(const nqm_gemm *g) {
    nqm_onednn_get()->dnnl_sgemm(g->trans_a ? 'T' : 'N', g->trans_b ? 'T' : 'N', (dnnl_dim_t)g->m, (dnnl_dim_t)g->n,
                                 (dnnl_dim_t)g->k, g->alpha, g->a, (dnnl_dim_t)g->lda, g->b, (dnnl_dim_t)g->ldb,
                                 g->beta, g->c, (dnnl_dim_t)g->ldc);
}
