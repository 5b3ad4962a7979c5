/* The only place that speaks C++ with OpenSubdiv: topology and rules in, rows of limit weights out. Far's
 * limit stencils name control vertices alone, so that evaluating a posed cage is one sparse product. */

#include "runtime/asset/subdiv_shim.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

using namespace OpenSubdiv;

namespace
{

Sdc::Options rules_of(const subdiv_cage &cage)
{
    static const Sdc::Options::VtxBoundaryInterpolation boundaries[] = {
        Sdc::Options::VTX_BOUNDARY_NONE, Sdc::Options::VTX_BOUNDARY_EDGE_ONLY,
        Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER};
    static const Sdc::Options::FVarLinearInterpolation linear[] = {
        Sdc::Options::FVAR_LINEAR_NONE,          Sdc::Options::FVAR_LINEAR_CORNERS_ONLY,
        Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1, Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2,
        Sdc::Options::FVAR_LINEAR_BOUNDARIES,    Sdc::Options::FVAR_LINEAR_ALL};
    Sdc::Options rules;
    rules.SetVtxBoundaryInterpolation(boundaries[cage.boundary]);
    rules.SetFVarLinearInterpolation(linear[cage.uv_rule]);
    return rules;
}

/* What Far would print: part of our one message instead. */
thread_local std::string complaint;

void keep_complaint(Far::ErrorType, const char *message)
{
    if (complaint.empty())
        complaint = message;
}

void drop_warning(const char *) {}

Far::TopologyRefiner *refiner_of(const subdiv_cage &cage)
{
    using factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Far::TopologyDescriptor d;
    Far::TopologyDescriptor::FVarChannel uv;
    d.numVertices = cage.vertex_count;
    d.numFaces = cage.face_count;
    d.numVertsPerFace = cage.face_sizes;
    d.vertIndicesPerFace = cage.corners;
    d.numCreases = cage.crease_count;
    d.creaseVertexIndexPairs = cage.creases;
    d.creaseWeights = cage.crease_sharpness;
    d.numCorners = cage.sharp_corner_count;
    d.cornerVertexIndices = cage.sharp_corners;
    d.cornerWeights = cage.corner_sharpness;
    uv.numValues = cage.uv_count;
    uv.valueIndices = cage.uv_corners;
    d.numFVarChannels = cage.uv_corners ? 1 : 0;
    d.fvarChannels = &uv;
    factory::Options options(cage.loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK, rules_of(cage));
    return factory::Create(d, options);
}

} /* namespace */

struct subdiv {
    subdiv_cage cage = {};
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::vector<int> corner_edges, edge_vertices;
    std::vector<uint8_t> edge_sharp, vertex_sharp, face_hole;
    subdiv_topology topology = {};
    std::unique_ptr<const Far::LimitStencilTableReal<float>>
        tables[2]; /* of vertices, of texture coordinates */
    std::vector<uint32_t> first[2];
};

namespace
{

void read_topology(subdiv &s)
{
    const Far::TopologyLevel &level = s.refiner->GetLevel(0);
    for (int f = 0; f < level.GetNumFaces(); f++) {
        const auto edges = level.GetFaceEdges(f);
        for (int i = 0; i < edges.size(); i++)
            s.corner_edges.push_back(edges[i]);
        s.face_hole.push_back(level.IsFaceHole(f));
    }
    for (int e = 0; e < level.GetNumEdges(); e++) {
        const auto ends = level.GetEdgeVertices(e);
        s.edge_vertices.push_back(ends[0]);
        s.edge_vertices.push_back(ends[1]);
        s.edge_sharp.push_back(level.GetEdgeSharpness(e) >= SUBDIV_INFINITELY_SHARP);
    }
    for (int v = 0; v < level.GetNumVertices(); v++)
        s.vertex_sharp.push_back(level.GetVertexSharpness(v) >= SUBDIV_INFINITELY_SHARP);
    s.topology = {level.GetNumEdges(), s.corner_edges.data(), s.edge_vertices.data(),
                  s.edge_sharp.data(), s.vertex_sharp.data(), s.face_hole.data()};
}

/* The parameters of a grid of n segments, as subdiv_stencils describes it. */
struct grid {
    std::vector<float> u, v;

    grid(int n, bool triangle)
    {
        for (int j = 0; j <= n; j++)
            for (int i = 0; i <= (triangle ? n - j : n); i++) {
                u.push_back(static_cast<float>(i) / static_cast<float>(n));
                v.push_back(static_cast<float>(j) / static_cast<float>(n));
            }
    }
};

/* Ptex numbers count every face's patches, those of holes too. */
void make_table(subdiv &s, int level, bool uv)
{
    using factory = Far::LimitStencilTableFactoryReal<float>;
    const grid whole(1 << level, s.cage.loop), half(1 << (level - 1), false);
    factory::LocationArrayVec places;
    int ptex = 0;
    for (int f = 0; f < s.cage.face_count; f++) {
        int patches = subdiv_patches(&s.cage, f);
        const grid &points = patches > 1 ? half : whole;
        for (int i = 0; i < patches && !s.face_hole[static_cast<size_t>(f)]; i++) {
            factory::LocationArray one;
            one.ptexIdx = ptex + i;
            one.numLocations = static_cast<int>(points.u.size());
            one.s = points.u.data();
            one.t = points.v.data();
            places.push_back(one);
        }
        ptex += patches;
    }
    factory::Options options;
    options.interpolationMode = uv ? factory::INTERPOLATE_FACE_VARYING : factory::INTERPOLATE_VERTEX;
    s.tables[uv].reset(factory::Create(*s.refiner, places, nullptr, nullptr, options));
}

void read_rows(subdiv &s, bool uv, subdiv_rows &out)
{
    const Far::LimitStencilTableReal<float> &t = *s.tables[uv];
    const auto &sizes = t.GetSizes();
    std::vector<uint32_t> &first = s.first[uv];
    first.assign(1, 0);
    for (int size : sizes)
        first.push_back(first.back() + static_cast<uint32_t>(size));
    out = {sizes.size(),           t.GetControlIndices().size(),
           first.data(),           t.GetControlIndices().data(),
           t.GetWeights().data(),  t.GetDuWeights().data(),
           t.GetDvWeights().data()};
}

/* Run a step that may throw. */
template <typename Step> kd_status guarded(char *error, size_t error_size, Step step)
{
    try {
        return step();
    } catch (const std::bad_alloc &) {
        std::snprintf(error, error_size, "out of memory while the cage is subdivided");
        return KD_NO_MEMORY;
    } catch (const std::exception &e) {
        std::snprintf(error, error_size, "the cage cannot be subdivided: %.160s", e.what());
        return KD_UNSUPPORTED;
    }
}

} /* namespace */

extern "C" int subdiv_isolation(const subdiv_cage *cage, int level)
{
    float sharpest = static_cast<float>(level);
    bool rounds = false; /* following creases that deep would cost too much */
    for (int i = 0; i < cage->crease_count; i++)
        if (cage->crease_sharpness[i] < SUBDIV_INFINITELY_SHARP)
            sharpest = std::max(sharpest, cage->crease_sharpness[i]), rounds |= cage->crease_sharpness[i] > 0;
    for (int i = 0; i < cage->sharp_corner_count; i++)
        if (cage->corner_sharpness[i] < SUBDIV_INFINITELY_SHARP)
            sharpest = std::max(sharpest, cage->corner_sharpness[i]), rounds |= cage->corner_sharpness[i] > 0;
    /* Far's patches at a rounded boundary corner are right in the limit only: their error falls by 4 a level,
     * from a tenth of the face. */
    if (cage->boundary == SUBDIV_EDGE_ONLY && !rounds)
        return SUBDIV_ISOLATION_CORNER;
    return std::min(static_cast<int>(std::ceil(sharpest)), std::max(level, SUBDIV_ISOLATION_MAX));
}

extern "C" subdiv *subdiv_open(const subdiv_cage *cage, int isolation, char *error, size_t error_size)
{
    std::unique_ptr<subdiv> s;
    kd_status status = guarded(error, error_size, [&] {
        complaint.clear();
        Far::SetErrorCallback(keep_complaint);
        Far::SetWarningCallback(drop_warning);
        s.reset(new subdiv);
        s->cage = *cage;
        s->refiner.reset(refiner_of(*cage));
        if (!s->refiner) {
            std::snprintf(error, error_size, "the faces form no surface that can be subdivided: %.120s",
                          complaint.c_str());
            return KD_UNSUPPORTED;
        }
        Far::TopologyRefiner::AdaptiveOptions options(static_cast<unsigned>(isolation));
        options.useInfSharpPatch = true;
        options.considerFVarChannels = cage->uv_corners != nullptr;
        s->refiner->RefineAdaptive(options);
        read_topology(*s);
        return KD_OK;
    });
    return status == KD_OK ? s.release() : nullptr;
}

extern "C" void subdiv_close(subdiv *s)
{
    delete s;
}

extern "C" const subdiv_topology *subdiv_topology_of(const subdiv *s)
{
    return &s->topology;
}

extern "C" kd_status subdiv_stencils(subdiv *s, int level, bool uv, subdiv_rows *out, char *error,
                                     size_t error_size)
{
    return guarded(error, error_size, [&] {
        make_table(*s, level, uv);
        if (!s->tables[uv]) {
            std::snprintf(error, error_size, "the faces have no limit surface");
            return KD_UNSUPPORTED;
        }
        read_rows(*s, uv, *out);
        return KD_OK;
    });
}
