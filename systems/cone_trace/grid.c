#include "systems/cone_trace/grid.h"

void grid_remake(kd_gpu *gpu, kd_gpu_texture *texture, kd_texture_format format, uint32_t width,
                 uint32_t height, const char *name)
{
    kd_gpu_destroy_texture(gpu, *texture);
    *texture = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){
                 .format = format, .width = width, .height = height, .filter = KD_NEAREST, .name = name});
}

bool grid_fit(kd_gpu *gpu, gather_grid *grid, uint32_t width, uint32_t height)
{
    if (grid->width == width && grid->height == height)
        return false;
    for (int i = 0; i < 3; i++) {
        grid_remake(gpu, &grid->diffuse[i], KD_RGBA16F, width, height, "gi.diffuse.traced");
        grid_remake(gpu, &grid->specular[i], KD_RGBA16F, width, height, "gi.specular.traced");
    }
    grid->width = width;
    grid->height = height;
    return true;
}

static void swap(kd_gpu_texture textures[3])
{
    kd_gpu_texture before = textures[GRID_BEFORE];
    textures[GRID_BEFORE] = textures[GRID_TRACED];
    textures[GRID_TRACED] = before;
}

void grid_begin_frame(gather_grid *grid)
{
    swap(grid->diffuse);
    swap(grid->specular);
}

void grid_destroy(kd_gpu *gpu, gather_grid *grid)
{
    for (int i = 0; i < 3; i++) {
        kd_gpu_destroy_texture(gpu, grid->diffuse[i]);
        kd_gpu_destroy_texture(gpu, grid->specular[i]);
    }
}
