#include "tests/osd_limit.h"

#include <memory>
#include <vector>

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

using namespace OpenSubdiv;

namespace
{

struct point {
    double x[3];

    void Clear()
    {
        x[0] = x[1] = x[2] = 0;
    }
    void AddWithWeight(const point &p, double weight)
    {
        for (int k = 0; k < 3; k++)
            x[k] += weight * p.x[k];
    }
};

} /* namespace */

extern "C" int osd_limit(const subdiv_cage *cage, int level, const float *cage_positions, float *positions)
{
    Far::TopologyDescriptor d;
    d.numVertices = cage->vertex_count;
    d.numFaces = cage->face_count;
    d.numVertsPerFace = cage->face_sizes;
    d.vertIndicesPerFace = cage->corners;
    d.numCreases = cage->crease_count;
    d.creaseVertexIndexPairs = cage->creases;
    d.creaseWeights = cage->crease_sharpness;
    d.numCorners = cage->sharp_corner_count;
    d.cornerVertexIndices = cage->sharp_corners;
    d.cornerWeights = cage->corner_sharpness;
    Sdc::Options rules;
    rules.SetVtxBoundaryInterpolation(cage->boundary == SUBDIV_EDGE_ONLY
                                          ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                          : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    using factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        factory::Create(d, factory::Options(cage->loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK, rules)));
    Far::TopologyRefiner::UniformOptions options(level);
    options.fullTopologyInLastLevel = true;
    refiner->RefineUniform(options);
    Far::PrimvarRefinerReal<double> primvars(*refiner);
    std::vector<point> points(static_cast<size_t>(cage->vertex_count)), next;
    for (size_t v = 0; positions && v < points.size(); v++)
        for (size_t k = 0; k < 3; k++)
            points[v].x[k] = cage_positions[3 * v + k];
    for (int l = 1; positions && l <= level; l++) {
        next.assign(static_cast<size_t>(refiner->GetLevel(l).GetNumVertices()), point());
        primvars.Interpolate(l, points, next);
        points.swap(next);
    }
    int count = refiner->GetLevel(level).GetNumVertices();
    if (!positions)
        return count;
    next.assign(static_cast<size_t>(count), point());
    primvars.Limit(points, next);
    for (size_t v = 0; v < next.size(); v++)
        for (size_t k = 0; k < 3; k++)
            positions[3 * v + k] = static_cast<float>(next[v].x[k]);
    return count;
}
