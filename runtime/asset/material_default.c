#include "runtime/asset/model.h"

static kd_texture_ref no_texture(void)
{
    return (kd_texture_ref){.image = KD_NONE, .scale = {1, 1}};
}

kd_material_desc kd_material_default(void)
{
    return (kd_material_desc){
        .name = "default",
        .base_color = {1, 1, 1, 1},
        .base_color_map = no_texture(),
        .metallic = 1,
        .roughness = 1,
        .metallic_roughness_map = no_texture(),
        .normal_map = no_texture(),
        .normal_scale = 1,
        .occlusion_map = no_texture(),
        .occlusion_strength = 1,
        .emissive_map = no_texture(),
        .alpha_mode = KD_ALPHA_OPAQUE,
        .alpha_cutoff = 0.5f,
        .ior = 1.5f,
        .specular = 1,
        .specular_color = {1, 1, 1},
    };
}
