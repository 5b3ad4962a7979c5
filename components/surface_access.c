#include "components/surface_access.h"

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

uint32_t kd_surface_kinds(const kd_gbuffer *g, const kd_lighting *lighting)
{
    return (lighting->directional_count > 0 ? 1u : 0u) |
           (lighting->light_count > lighting->directional_count ? 2u : 0u) | (g->blended.id != 0 ? 4u : 0u) |
           (g->blended_hidden.id != 0 ? 8u : 0u) | (g->layers.id != 0 ? 16u : 0u);
}

int kd_surface_defines(uint32_t kinds, const char **out)
{
    static const char *const words[] = {"DIRECTIONAL", "LOCAL", "BLENDED", "TINTED", "LAYERED"};
    int count = 0;
    for (uint32_t i = 0; i < sizeof words / sizeof *words; i++)
        if (kinds >> i & 1)
            out[count++] = words[i];
    return count;
}

void kd_surface_bind(kd_gpu *gpu, const kd_gbuffer *g, const kd_lighting *lighting, const kd_sky_light *sky)
{
    const struct {
        uint32_t unit;
        kd_gpu_texture texture;
        bool optional; /* bound when there is one */
    } rows[] = {{KD_UNIT_GBUFFER_ALBEDO, g->albedo, false},
                {KD_UNIT_GBUFFER_NORMAL, g->normal, false},
                {KD_UNIT_GBUFFER_MATERIAL, g->material, false},
                {KD_UNIT_GBUFFER_EMISSIVE, g->emissive, false},
                {KD_UNIT_GBUFFER_DEPTH, g->depth, false},
                {KD_UNIT_SHADOW_DIRECTIONAL, lighting->shadow_directional, false},
                {KD_UNIT_SHADOW_SPOT, lighting->shadow_spot, false},
                {KD_UNIT_GBUFFER_LAYERS, g->layers, true},
                {KD_UNIT_BLENDED, g->blended, true},
                {KD_UNIT_BLENDED_TINT, g->blended_hidden, true}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (rows[i].texture.id != 0 || !rows[i].optional)
            kd_gpu_bind_texture(gpu, rows[i].unit, rows[i].texture);
    kd_sky_bind(gpu, sky);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_LIGHTS, lighting->lights, 0, sizeof(struct kd_lights_params));
}

void kd_surface_bind_gathered(kd_gpu *gpu, const kd_gi_targets *gi, bool there, kd_gpu_texture black)
{
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_DIFFUSE, there ? gi->diffuse : black);
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_SPECULAR, there && gi->specular.id != 0 ? gi->specular : black);
}
