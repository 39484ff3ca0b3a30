#include "geometry/far_reference.h"

#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <memory>
#include <vector>

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

static const int deepest = 10;

namespace {
struct Point {
    double x[3];
    void Clear(void * = nullptr) { x[0] = x[1] = x[2] = 0.0; }
    void AddWithWeight(const Point &p, double weight)
    {
        for (int k = 0; k < 3; k++)
            x[k] += weight * p.x[k];
    }
};
} // namespace

struct FarReference {
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::unique_ptr<Far::PatchTable> table;
    std::unique_ptr<Far::PatchMap> map;
    std::unique_ptr<Far::PtexIndices> ptex;
    std::vector<Point> points;
};

static Sdc::Options options_of(const CohortMeshDesc *desc)
{
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(
        desc->interpolate_boundary == COHORT_BOUNDARY_NONE
            ? Sdc::Options::VTX_BOUNDARY_NONE
            : (desc->interpolate_boundary == COHORT_BOUNDARY_EDGE_ONLY
                   ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                   : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER));
    options.SetTriangleSubdivision(desc->triangle_rule_smooth ? Sdc::Options::TRI_SUB_SMOOTH
                                                              : Sdc::Options::TRI_SUB_CATMARK);
    return options;
}

static Far::TopologyRefiner *refiner_of(const CohortMeshDesc *desc)
{
    std::vector<int> pairs;
    std::vector<float> weights;
    for (size_t k = 0, at = 0; k < desc->crease_count; at += (size_t)desc->crease_lengths[k++]) {
        for (int m = 1; m < desc->crease_lengths[k]; m++) {
            pairs.push_back(desc->crease_indices[at + (size_t)m - 1]);
            pairs.push_back(desc->crease_indices[at + (size_t)m]);
            weights.push_back(desc->crease_sharpnesses[k]);
        }
    }
    Far::TopologyDescriptor topology;
    topology.numVertices = (int)desc->point_count;
    topology.numFaces = (int)desc->face_count;
    topology.numVertsPerFace = desc->face_vertex_counts;
    topology.vertIndicesPerFace = desc->face_vertex_indices;
    topology.numCreases = (int)weights.size();
    topology.creaseVertexIndexPairs = pairs.data();
    topology.creaseWeights = weights.data();
    topology.numCorners = (int)desc->corner_count;
    topology.cornerVertexIndices = desc->corner_indices;
    topology.cornerWeights = desc->corner_sharpnesses;
    topology.numHoles = (int)desc->hole_count;
    topology.holeIndices = desc->hole_indices;
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Sdc::SchemeType scheme =
        desc->scheme == COHORT_SCHEME_LOOP
            ? Sdc::SCHEME_LOOP
            : (desc->scheme == COHORT_SCHEME_BILINEAR ? Sdc::SCHEME_BILINEAR : Sdc::SCHEME_CATMARK);
    return Factory::Create(topology, Factory::Options(scheme, options_of(desc)));
}

static void refine_points(FarReference *r, const CohortMeshDesc *desc)
{
    int count = r->refiner->GetNumVerticesTotal();
    r->points.resize((size_t)(count + r->table->GetNumLocalPoints()));
    for (size_t k = 0; k < 3 * desc->point_count; k++)
        r->points[k / 3].x[k % 3] = (double)desc->points[k];
    Far::PrimvarRefinerReal<double> primvars(*r->refiner);
    Point *from = r->points.data();
    for (int level = 1; level <= r->refiner->GetMaxLevel(); level++) {
        Point *to = from + r->refiner->GetLevel(level - 1).GetNumVertices();
        primvars.Interpolate(level, from, to);
        from = to;
    }
    const Far::StencilTableReal<double> *stencils = r->table->GetLocalPointStencilTable<double>();
    if (stencils)
        stencils->UpdateValues(r->points.data(), r->points.data() + count);
}

FarReference *far_reference_create(const CohortMeshDesc *desc)
{
    std::unique_ptr<FarReference> r(new FarReference);
    r->refiner.reset(refiner_of(desc));
    if (!r->refiner)
        return nullptr;
    Far::PatchTableFactory::Options options(deepest);
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
    options.SetPatchPrecision<double>();
    options.useInfSharpPatch = true;
    Far::TopologyRefiner::AdaptiveOptions adaptive = options.GetRefineAdaptiveOptions();
    adaptive.secondaryLevel = (unsigned)deepest;
    r->refiner->RefineAdaptive(adaptive);
    r->table.reset(Far::PatchTableFactory::Create(*r->refiner, options));
    r->map.reset(new Far::PatchMap(*r->table));
    r->ptex.reset(new Far::PtexIndices(*r->refiner));
    refine_points(r.get(), desc);
    return r.release();
}

void far_reference_destroy(FarReference *reference)
{
    delete reference;
}

bool far_reference_limit(const FarReference *r, uint32_t face, uint32_t sub, double u, double v,
                         double out[3])
{
    const Far::PatchTable::PatchHandle *handle =
        r->map->FindPatch(r->ptex->GetFaceId((int)face) + (int)sub, u, v);
    if (!handle)
        return false;
    double weights[32];
    r->table->EvaluateBasis(*handle, u, v, weights);
    Far::ConstIndexArray control = r->table->GetPatchVertices(*handle);
    out[0] = out[1] = out[2] = 0.0;
    for (int k = 0; k < control.size(); k++)
        for (int c = 0; c < 3; c++)
            out[c] += weights[k] * r->points[(size_t)control[k]].x[c];
    return true;
}
