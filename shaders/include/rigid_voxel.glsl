// Static voxels: from the cache to the grid. They are not kept in the pages; the passes that need them come here, and all get
// the same words, because nothing in the way is left to the compiler (precise).

#include "shaders/include/splat.glsl"

#include "shaders/include/rigid.glsl"

struct rigid_voxel {
    bool inside;   // of its cascade, or at its border
    splat place;
};

// c: cascade, origin: of the chunk, cached: word of its position
rigid_voxel rigid_voxel_of(uint c, kd_voxel_object_params o, vec4 origin, uint cached)
{
    kd_voxel_chunk_params chunk;
    chunk.origin = origin;
    precise vec3 position = rigid_position(o, rigid_model_position(chunk, cached)) / tree.cascade[c].w;
    rigid_voxel v;
    v.inside = splat_inside(c, position);
    v.place = splat_at(c, v.inside ? position : vec3(0.0));
    return v;
}

// 3 x snorm8
uint rigid_voxel_normal(kd_voxel_object_params o, uint cached)
{
    vec3 n = vec3(snorm8_unpack(cached)) / 127.0;
    return rigid_pack_normal(rigid_normal(o, n), length(n));
}
