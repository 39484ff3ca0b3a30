#include "shims/osd_topology.hpp"

extern "C" {
#include "base/error.h"
}

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/error.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <new>
#include <shared_mutex>
#include <string>
#include <vector>

namespace Bfr = OpenSubdiv::Bfr;
namespace Far = OpenSubdiv::Far;

using Cache =
    Bfr::SurfaceFactoryCacheThreaded<std::shared_mutex, std::shared_lock<std::shared_mutex>,
                                     std::unique_lock<std::shared_mutex>>;
using Factory = Bfr::RefinerSurfaceFactory<Cache>;
using Surface = Bfr::Surface<float>;

struct CoOsdMesh {
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::unique_ptr<Factory> factory;
    bool has_normal_seams;
};

struct CoOsdSurface {
    const CoOsdMesh *mesh;
    Surface surface;
    std::vector<float> points;
    int components = 0;
};

// Bfr's work on an irregular feature grows with the cube of its valence: 1000 takes seconds.
static const int max_valence = 1000;

// How deep OpenSubdiv isolates features at most.
static const int deepest = 10;

// OpenSubdiv reports through process-wide callbacks, which print unless they are set. It calls them
// on the thread that made the mistake, so each thread keeps its own last sentence.
static thread_local char osd_error[256], osd_warning[256];

static void keep_error(Far::ErrorType, const char *message)
{
    std::snprintf(osd_error, sizeof osd_error, "%s", message);
}

static void keep_warning(const char *message)
{
    std::snprintf(osd_warning, sizeof osd_warning, "%s", message);
}

static void catch_messages()
{
    static std::once_flag once;
    std::call_once(once, [] {
        Far::SetErrorCallback(keep_error);
        Far::SetWarningCallback(keep_warning);
    });
    osd_error[0] = osd_warning[0] = 0;
}

// Inside a catch block: turns what was thrown into a CohortError.
static bool rethrown(CohortError *err)
{
    try {
        throw;
    } catch (const std::bad_alloc &) {
        return CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory in OpenSubdiv");
    } catch (const std::exception &e) {
        return CO_FAIL(err, COHORT_ERROR_SCENE, "OpenSubdiv: %.160s", e.what());
    } catch (...) {
        return CO_FAIL(err, COHORT_ERROR_INTERNAL, "OpenSubdiv threw something unknown");
    }
}

CoOsdMesh *co_osd_create(const CoOsdDesc *desc, char warning[256], CohortError *err)
{
    try {
        catch_messages();
        std::unique_ptr<CoOsdMesh> mesh(new CoOsdMesh);
        mesh->refiner.reset(co_osd_refiner(desc));
        CO_CHECK_NULL(mesh->refiner, err, COHORT_ERROR_SCENE, "OpenSubdiv refuses it: %.160s",
                      osd_error[0] ? osd_error : "no reason given");
        int valence = mesh->refiner->GetMaxValence();
        CO_CHECK_NULL(desc->scheme == COHORT_SCHEME_BILINEAR || valence <= max_valence, err,
                      COHORT_ERROR_LIMIT,
                      "a vertex or face has %d edges, smooth subdivision takes at most %d", valence,
                      max_valence);
        const Far::TopologyLevel cage = mesh->refiner->GetLevel(0);
        mesh->has_normal_seams = co_osd_find_normal_seams(cage);
        // Bfr takes a point of level L exactly when it isolates irregular features that deep.
        bool is_deep = co_osd_find_deep_features(cage);
        int level = is_deep ? deepest : (int)std::min(std::max(desc->exact_level, 2u), 6u);
        Factory::Options options;
        options.SetApproxLevelSmooth(level);
        options.SetApproxLevelSharp(is_deep ? deepest : 6);
        mesh->factory.reset(new Factory(*mesh->refiner, options));
        std::snprintf(warning, 256, "%s", osd_warning);
        return mesh.release();
    } catch (...) {
        rethrown(err);
        return nullptr;
    }
}

void co_osd_destroy(CoOsdMesh *mesh)
{
    delete mesh;
}

uint32_t co_osd_edge_count(const CoOsdMesh *mesh)
{
    return (uint32_t)mesh->refiner->GetLevel(0).GetNumEdges();
}

void co_osd_edge_vertices(const CoOsdMesh *mesh, uint32_t edge, uint32_t vertices[2])
{
    Far::ConstIndexArray ends = mesh->refiner->GetLevel(0).GetEdgeVertices((int)edge);
    vertices[0] = (uint32_t)ends[0];
    vertices[1] = (uint32_t)ends[1];
}

const int32_t *co_osd_face_edges(const CoOsdMesh *mesh, uint32_t face)
{
    return &mesh->refiner->GetLevel(0).GetFaceEdges((int)face)[0];
}

bool co_osd_face_has_limit(const CoOsdMesh *mesh, uint32_t face, bool *has, CohortError *err)
{
    try {
        *has = mesh->factory->FaceHasLimitSurface((int)face);
        return true;
    } catch (...) {
        return rethrown(err);
    }
}

bool co_osd_has_normal_seams(const CoOsdMesh *mesh)
{
    return mesh->has_normal_seams;
}

CoOsdSurface *co_osd_surface_create(const CoOsdMesh *mesh, CohortError *err)
{
    try {
        CoOsdSurface *surface = new CoOsdSurface;
        surface->mesh = mesh;
        return surface;
    } catch (...) {
        rethrown(err);
        return nullptr;
    }
}

void co_osd_surface_destroy(CoOsdSurface *surface)
{
    delete surface;
}

bool co_osd_surface_begin(CoOsdSurface *surface, uint32_t face, int32_t channel, CohortError *err)
{
    try {
        const Factory &factory = *surface->mesh->factory;
        bool ok = channel < 0
                      ? factory.InitVertexSurface((int)face, &surface->surface)
                      : factory.InitFaceVaryingSurface((int)face, &surface->surface, channel);
        CO_CHECK(ok, err, COHORT_ERROR_SCENE, "OpenSubdiv finds no limit surface of face %u", face);
        return true;
    } catch (...) {
        return rethrown(err);
    }
}

bool co_osd_surface_values(CoOsdSurface *surface, const float *values, uint32_t components,
                           bool *finite, CohortError *err)
{
    try {
        const Surface &s = surface->surface;
        Surface::PointDescriptor layout((int)components);
        surface->components = (int)components;
        surface->points.resize((size_t)s.GetNumPatchPoints() * components);
        s.GatherControlPoints(values, layout, surface->points.data(), layout);
        if (finite) {
            size_t count = (size_t)s.GetNumControlPoints() * components;
            *finite = std::all_of(surface->points.begin(), surface->points.begin() + (long)count,
                                  [](float x) { return std::isfinite(x); });
        }
        s.ComputePatchPoints(surface->points.data(), layout);
        return true;
    } catch (...) {
        return rethrown(err);
    }
}

bool co_osd_surface_eval(CoOsdSurface *surface, const CoOsdCoord *coords, uint32_t count, float *p,
                         float *du, float *dv, CohortError *err)
{
    try {
        const Surface &s = surface->surface;
        Surface::PointDescriptor layout(surface->components);
        Bfr::Parameterization param = s.GetParameterization();
        for (uint32_t k = 0; k < count; k++) {
            const float sub_uv[2] = {coords[k].u, coords[k].v};
            float uv[2] = {sub_uv[0], sub_uv[1]};
            if (param.HasSubFaces())
                param.ConvertNormalizedSubFaceToCoord((int)coords[k].sub, sub_uv, uv);
            size_t at = (size_t)k * (size_t)surface->components;
            if (du)
                s.Evaluate(uv, surface->points.data(), layout, p + at, du + at, dv + at);
            else
                s.Evaluate(uv, surface->points.data(), layout, p + at);
        }
        return true;
    } catch (...) {
        return rethrown(err);
    }
}

const char *co_osd_version(void)
{
    return CO_STRINGIFY(OPENSUBDIV_VERSION_MAJOR) "." CO_STRINGIFY(OPENSUBDIV_VERSION_MINOR) "."
           CO_STRINGIFY(OPENSUBDIV_VERSION_PATCH);
}
