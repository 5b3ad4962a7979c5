/* `kandil info FILE.kvox`. */
#include <stdio.h>
#include <stdlib.h>

#include "components/voxel_scene.h"
#include "runtime/app/voxelize.h"
#include "runtime/asset/voxel_file.h"
#include "runtime/core/log.h"

kd_status app_voxel_file_open(kd_voxel_file *file, const char *path)
{
    char why[KD_VOXEL_WHY];
    kd_status status = kd_voxel_file_open(file, path, why);
    if (status == KD_NOT_FOUND)
        return kd_fail(status, "%s: no such file; make it with `kandil voxelize`", path);
    return status ? kd_fail(status, "%s: %s; make it again with `kandil voxelize`", path, why) : KD_OK;
}

/* Unpack every block of a level. */
static kd_status check_level(const kd_voxel_file *file, const kd_voxel_level *level, const char *path)
{
    for (uint32_t i = 0; i < level->block_count; i++) {
        const size_t n = file->blocks[level->first_block + i].count;
        bool binds = kd_voxel_level_binds(level);
        uint32_t *memory = malloc(n * (binds ? 24 : 12));
        if (!memory)
            return kd_fail(KD_NO_MEMORY, "%s: out of memory for %zu voxels", path, n);
        const kd_voxel_words words = {memory, memory + 2 * n, binds ? memory + 3 * n : NULL};
        kd_status status = kd_voxel_file_read(file, level->first_block + i, &words);
        free(memory);
        if (status)
            return kd_fail(status,
                           "%s: it is damaged: block %u cannot be read; make it again with `kandil voxelize`",
                           path, level->first_block + i);
    }
    return KD_OK;
}

static uint64_t bytes_in_file(const kd_voxel_file *file, const kd_voxel_level *level)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < level->block_count; i++)
        bytes += file->blocks[level->first_block + i].bytes;
    return bytes;
}

/* On the GPU and in the lists of the CPU, all told. */
static uint64_t bytes_in_memory(const kd_voxel_level *level)
{
    uint64_t voxel = 12 + (kd_voxel_level_binds(level) ? KD_BINDING_WORDS * 4 : 0);
    return level->voxel_count * voxel + sizeof(kd_voxel_cache) +
           level->block_count * (sizeof(kd_voxel_chunk) + sizeof(struct kd_voxel_chunk_params));
}

static double each(uint64_t bytes, uint64_t voxels)
{
    return voxels ? (double)bytes / (double)voxels : 0;
}

static void print_level(const kd_voxel_file *file, const kd_voxel_level *l)
{
    static const char *const kinds[] = {"rigid", "skinned", "attached"};
    printf("  mesh %-4u primitive %-4u %-8s span %-10.4g %10llu voxels in %u blocks, bytes each: %.2f in "
           "memory, %.2f "
           "in the file%s%s\n",
           l->mesh, l->primitive, kinds[l->kind], (double)l->span, (unsigned long long)l->voxel_count,
           l->block_count, each(bytes_in_memory(l), l->voxel_count),
           each(bytes_in_file(file, l), l->voxel_count), l->flags & KD_VOXEL_LEVEL_THIN ? ", thin" : "",
           l->flags & KD_VOXEL_LEVEL_FILLED ? ", filled" : "");
}

kd_status app_voxel_info(const char *path)
{
    kd_voxel_file file;
    kd_status status = app_voxel_file_open(&file, path);
    uint64_t voxels[2] = {0}, memory[2] = {0}, blocks = 0; /* rigid, deforming */
    for (uint32_t i = 0; i < file.level_count && !status; i++) {
        const kd_voxel_level *l = &file.levels[i];
        bool binds = kd_voxel_level_binds(l);
        status = check_level(&file, l, path);
        voxels[binds] += l->voxel_count;
        memory[binds] += bytes_in_memory(l);
        blocks += l->block_count;
    }
    if (!status) {
        printf("%s\n  version %u, %u levels, %llu blocks, %zu bytes\n", path, KD_VOXEL_FILE_VERSION,
               file.level_count, (unsigned long long)blocks, file.map.size);
        for (int k = 0; k < 2; k++)
            if (voxels[k])
                printf("  %s: %llu voxels, %.2f bytes each in memory\n", k ? "deforming" : "rigid",
                       (unsigned long long)voxels[k], each(memory[k], voxels[k]));
        for (uint32_t i = 0; i < file.level_count; i++)
            print_level(&file, &file.levels[i]);
    }
    kd_voxel_file_close(&file);
    return status;
}
