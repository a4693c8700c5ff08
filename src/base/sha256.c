/* SPDX-License-Identifier: MIT
 *
 * SHA-256, computed by OpenSSL's libcrypto.
 */
#include "base/base.h"

#include <openssl/evp.h>

bool nqm_sha256_begin(nqm_sha256 *sha) {
    EVP_MD_CTX *context = EVP_MD_CTX_new();
    if (context && EVP_DigestInit_ex(context, EVP_sha256(), NULL) != 1) {
        EVP_MD_CTX_free(context);
        context = NULL;
    }
    sha->context = context;
    return context != NULL;
}

void nqm_sha256_add(nqm_sha256 *sha, const void *data, size_t n_bytes) {
    EVP_DigestUpdate(sha->context, data, n_bytes);
}

void nqm_sha256_end(nqm_sha256 *sha, char hex[65]) {
    unsigned char sum[EVP_MAX_MD_SIZE] = {0};
    EVP_DigestFinal_ex(sha->context, sum, NULL);
    EVP_MD_CTX_free(sha->context);
    sha->context = NULL;
    for (size_t i = 0; i < 32; ++i)
        snprintf(hex + 2 * i, 3, "%02x", sum[i]);
}
