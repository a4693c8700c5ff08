/* SPDX-License-Identifier: MIT
 *
 * Reads the input as a mesh. An accepted mesh must have finite positions, unit normals and indices in range.
 */
#include "fuzz.h"
#include "io/io.h"

#include <math.h>
#include <stdlib.h>

void fuzz_mesh(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz.mesh"};
    nqm_mesh mesh;
    nqm_error err = {0};
    nqm_status status = nqm_mesh_parse(&map, &mesh, &err);
    if (status != NQM_OK) {
        must(!mesh.position && !mesh.triangle && !mesh.normal && err.message[0] && status != NQM_ERR_NOMEM);
        return;
    }
    must(mesh.n_triangles > 0 && mesh.n_triangles < n_bytes && mesh.n_vertices < 3 * n_bytes);
    for (size_t i = 0; i < 3 * mesh.n_triangles; ++i)
        must(mesh.triangle[i] < mesh.n_vertices);
    for (size_t i = 0; i < mesh.n_vertices; ++i) {
        const float *p = mesh.position + 3 * i, *n = mesh.normal + 3 * i;
        must(isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]));
        must(fabs(sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2]) - 1) <
             1e-5);
    }
    nqm_mesh_free(&mesh);
}
