// The cage of a mesh, from arrays to a refiner of OpenSubdiv.

#include "shims/osd_topology.hpp"

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <vector>

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

static Sdc::SchemeType scheme_type(CohortScheme scheme)
{
    switch (scheme) {
    case COHORT_SCHEME_LOOP:
        return Sdc::SCHEME_LOOP;
    case COHORT_SCHEME_BILINEAR:
        return Sdc::SCHEME_BILINEAR;
    default:
        return Sdc::SCHEME_CATMARK;
    }
}

static Sdc::Options scheme_options(const CoOsdDesc *desc)
{
    static const Sdc::Options::VtxBoundaryInterpolation boundary[] = {
        Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER, Sdc::Options::VTX_BOUNDARY_EDGE_ONLY,
        Sdc::Options::VTX_BOUNDARY_NONE};
    static const Sdc::Options::FVarLinearInterpolation linear[] = {
        Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1, Sdc::Options::FVAR_LINEAR_NONE,
        Sdc::Options::FVAR_LINEAR_CORNERS_ONLY,  Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2,
        Sdc::Options::FVAR_LINEAR_BOUNDARIES,    Sdc::Options::FVAR_LINEAR_ALL};
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(boundary[desc->interpolate_boundary]);
    options.SetFVarLinearInterpolation(linear[desc->fvar_linear]);
    options.SetCreasingMethod(Sdc::Options::CREASE_UNIFORM);
    options.SetTriangleSubdivision(desc->triangle_rule_smooth ? Sdc::Options::TRI_SUB_SMOOTH
                                                              : Sdc::Options::TRI_SUB_CATMARK);
    return options;
}

Far::TopologyRefiner *co_osd_refiner(const CoOsdDesc *desc)
{
    using RefinerFactory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::vector<Far::TopologyDescriptor::FVarChannel> channels((size_t)desc->channel_count);
    for (size_t k = 0; k < channels.size(); k++) {
        channels[k].numValues = desc->channels[k].value_count;
        channels[k].valueIndices = desc->channels[k].indices;
    }
    Far::TopologyDescriptor topology;
    topology.numVertices = desc->vertex_count;
    topology.numFaces = desc->face_count;
    topology.numVertsPerFace = desc->face_vertex_counts;
    topology.vertIndicesPerFace = desc->face_vertex_indices;
    topology.numCreases = desc->crease_count;
    topology.creaseVertexIndexPairs = desc->crease_pairs;
    topology.creaseWeights = desc->crease_sharpnesses;
    topology.numCorners = desc->corner_count;
    topology.cornerVertexIndices = desc->corners;
    topology.cornerWeights = desc->corner_sharpnesses;
    topology.numFVarChannels = desc->channel_count;
    topology.fvarChannels = channels.data();
    RefinerFactory::Options options(scheme_type(desc->scheme), scheme_options(desc));
    options.validateFullTopology = true;
    return RefinerFactory::Create(topology, options);
}

bool co_osd_find_normal_seams(const Far::TopologyLevel &level)
{
    const float infinite = Sdc::Crease::SHARPNESS_INFINITE;
    for (int e = 0; e < level.GetNumEdges(); e++)
        if (level.IsEdgeNonManifold(e) ||
            (level.GetEdgeSharpness(e) >= infinite && level.GetEdgeFaces(e).size() > 1))
            return true;
    for (int v = 0; v < level.GetNumVertices(); v++)
        if (level.IsVertexNonManifold(v) ||
            (level.GetVertexSharpness(v) >= infinite && level.GetVertexFaces(v).size() > 1))
            return true;
    return false;
}

bool co_osd_find_deep_features(const Far::TopologyLevel &level)
{
    const float infinite = Sdc::Crease::SHARPNESS_INFINITE, lasting = 4.0f;
    for (int e = 0; e < level.GetNumEdges(); e++)
        if (level.GetEdgeSharpness(e) > lasting && level.GetEdgeSharpness(e) < infinite)
            return true;
    for (int v = 0; v < level.GetNumVertices(); v++) {
        if (level.GetVertexSharpness(v) > lasting && level.GetVertexSharpness(v) < infinite)
            return true;
        Far::ConstIndexArray edges = level.GetVertexEdges(v);
        if (std::count_if(edges.begin(), edges.end(),
                          [&](int e) { return level.GetEdgeSharpness(e) >= infinite; }) == 1)
            return true;
    }
    return false;
}
