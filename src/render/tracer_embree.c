/* SPDX-License-Identifier: MIT
 *
 * Ray intersection with a mesh by Embree 3 (Wald et al. 2014, DOI 10.1145/2601097.2601199), single-threaded: the caller's
 * threads trace the rays. The SSE2 kernels are selected because they use no fused operations, so that a scene is identical
 * on every processor; creating a scene becomes a few percent slower.
 */
#include "base/os.h"
#include "render/render.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <string.h>

#define EMBREE_FUNCTIONS(X)                                                                                            \
    X(rtcGetDeviceError)                                                                                               \
    X(rtcNewGeometry)                                                                                                  \
    X(rtcSetNewGeometryBuffer)                                                                                         \
    X(rtcCommitGeometry)                                                                                               \
    X(rtcAttachGeometry)                                                                                               \
    X(rtcReleaseGeometry)                                                                                              \
    X(rtcNewDevice)                                                                                                    \
    X(rtcNewScene)                                                                                                     \
    X(rtcSetSceneFlags)                                                                                                \
    X(rtcCommitScene)                                                                                                  \
    X(rtcReleaseScene)                                                                                                 \
    X(rtcReleaseDevice)                                                                                                \
    X(rtcIntersect1)                                                                                                   \
    X(rtcOccluded1)

/* NOLINTNEXTLINE(bugprone-macro-parentheses): a member name takes no parentheses */
#define MEMBER(name) __typeof__(name) *name;
#define NAME(name)   #name,
static struct { EMBREE_FUNCTIONS(MEMBER) } embree;
static pthread_once_t once = PTHREAD_ONCE_INIT;
static bool is_loaded;

static void load(void) {
    static const char *const names[] = {EMBREE_FUNCTIONS(NAME)};
    is_loaded = nqm_dynamic_load(NQM_EMBREE_SONAME, sizeof names / sizeof *names, names, &embree);
}

struct nqm_tracer {
    RTCDevice device;
    RTCScene scene;
};

const char *nqm_tracer_version(void) {
    return RTC_VERSION_STRING;
}

/* Embree and its threading library are loaded with the first mesh. */
bool nqm_tracer_available(void) {
    pthread_once(&once, load);
    return is_loaded;
}

static nqm_status fail_embree(RTCDevice device, nqm_error *err) {
    enum RTCError code = embree.rtcGetDeviceError(device);
    if (code == RTC_ERROR_OUT_OF_MEMORY)
        return nqm_fail(err, NQM_ERR_NOMEM, -1, "out of memory in Embree");
    return nqm_fail(err, NQM_ERR_NUMERIC, -1, "Embree cannot build the scene (its error %d)", (int)code);
}

static bool add_triangles(nqm_tracer *t, const nqm_mesh *mesh) {
    RTCGeometry geometry = embree.rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *position = embree.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                    3 * sizeof(float), mesh->n_vertices);
    void *triangle = embree.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                    3 * sizeof(uint32_t), mesh->n_triangles);
    bool ok = position && triangle;
    if (ok) {
        memcpy(position, mesh->position, mesh->n_vertices * 3 * sizeof(float));
        memcpy(triangle, mesh->triangle, mesh->n_triangles * 3 * sizeof(uint32_t));
        embree.rtcCommitGeometry(geometry);
        embree.rtcAttachGeometry(t->scene, geometry);
    }
    embree.rtcReleaseGeometry(geometry);
    return ok;
}

nqm_status nqm_tracer_create(const nqm_mesh *mesh, nqm_tracer **tracer_ret, nqm_error *err) {
    *tracer_ret = NULL;
    if (!nqm_tracer_available())
        return nqm_fail(err, NQM_ERR_IO, -1, "meshes need the library %s, which cannot be loaded", NQM_EMBREE_SONAME);
    nqm_tracer *t = nqm_alloc(1, sizeof *t);
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    t->device = embree.rtcNewDevice("threads=1,isa=sse2");
    t->scene = t->device ? embree.rtcNewScene(t->device) : NULL;
    bool ok = t->scene != NULL;
    if (ok) {
        embree.rtcSetSceneFlags(t->scene, RTC_SCENE_FLAG_ROBUST); /* no gaps between adjacent triangles */
        ok = add_triangles(t, mesh);
        embree.rtcCommitScene(t->scene);
    }
    if (!ok || embree.rtcGetDeviceError(t->device) != RTC_ERROR_NONE) {
        nqm_status status = fail_embree(t->device, err);
        nqm_tracer_free(t);
        return status;
    }
    *tracer_ret = t;
    return NQM_OK;
}

void nqm_tracer_free(nqm_tracer *tracer) {
    if (!tracer)
        return;
    if (tracer->scene)
        embree.rtcReleaseScene(tracer->scene);
    if (tracer->device)
        embree.rtcReleaseDevice(tracer->device);
    nqm_free(tracer);
}

static struct RTCRay make_ray(const double *origin, const double *direction) {
    return (struct RTCRay){.org_x = (float)origin[0],
                           .org_y = (float)origin[1],
                           .org_z = (float)origin[2],
                           .dir_x = (float)direction[0],
                           .dir_y = (float)direction[1],
                           .dir_z = (float)direction[2],
                           .tfar = INFINITY,
                           .mask = UINT32_MAX};
}

bool nqm_tracer_hit(const nqm_tracer *tracer, const double *origin, const double *direction, size_t *triangle,
                    double *corner_weight) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit ray = {.ray = make_ray(origin, direction), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    embree.rtcIntersect1(tracer->scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    *triangle = ray.hit.primID;
    corner_weight[1] = (double)ray.hit.u;
    corner_weight[2] = (double)ray.hit.v;
    corner_weight[0] = 1 - corner_weight[1] - corner_weight[2];
    return true;
}

bool nqm_tracer_blocked(const nqm_tracer *tracer, const double *origin, const double *direction) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    struct RTCRay ray = make_ray(origin, direction);
    embree.rtcOccluded1(tracer->scene, &context, &ray);
    return ray.tfar < 0;
}
