// From a rigid object's cached voxels to the world. What decides on cells is left to no compiler (precise): every pass comes
// to the same ones.

vec3 rigid_model_position(kd_voxel_chunk_params chunk, uint cell_word)
{
    precise vec3 p = chunk.origin.xyz + (vec3(cell_unpack(cell_word)) + 0.5) * chunk.origin.w;
    return p;
}

vec3 rigid_position(kd_voxel_object_params o, vec3 p)
{
    precise vec3 p_ws = vec3(o.model_ws[0].x * p.x + o.model_ws[0].y * p.y + o.model_ws[0].z * p.z + o.model_ws[0].w,
                             o.model_ws[1].x * p.x + o.model_ws[1].y * p.y + o.model_ws[1].z * p.z + o.model_ws[1].w,
                             o.model_ws[2].x * p.x + o.model_ws[2].y * p.y + o.model_ws[2].z * p.z + o.model_ws[2].w);
    return p_ws;
}

vec3 rigid_normal(kd_voxel_object_params o, vec3 n)
{
    precise vec3 n_ws = vec3(o.normal_ws[0].x * n.x + o.normal_ws[0].y * n.y + o.normal_ws[0].z * n.z,
                             o.normal_ws[1].x * n.x + o.normal_ws[1].y * n.y + o.normal_ws[1].z * n.z,
                             o.normal_ws[2].x * n.x + o.normal_ws[2].y * n.y + o.normal_ws[2].z * n.z);
    return n_ws;
}

// 3 x snorm8; `gathered`: length of the cached normal, below 1 where surfaces of several directions meet
uint rigid_pack_normal(vec3 n_ws, float gathered)
{
    precise float length2 = n_ws.x * n_ws.x + n_ws.y * n_ws.y + n_ws.z * n_ws.z;
    precise vec3 n = length2 > 0.0 ? n_ws * (gathered / sqrt(length2)) : vec3(0.0);
    return snorm8_pack(n);
}
