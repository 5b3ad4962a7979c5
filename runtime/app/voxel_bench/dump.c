/* The folder, its tables and index.json, which is written last: a folder with it is complete. */
#include "runtime/app/voxel_bench/dump.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"

enum { DUMP_VERSION = 1 };
#define INDEX "index.json"

/* ---- tables ---- */

kd_status dump_begin(dump *d, const char *name)
{
    char path[KD_PATH_MAX];
    struct stat info;
    d->rows = 0;
    kd_status status = kd_path_join(path, sizeof path, d->folder, name);
    if (status != KD_OK)
        return kd_fail(status, "--dump: %s: the path is too long; choose a shorter one", d->folder);
    if (lstat(path, &info) == 0)
        return kd_fail(KD_IO, "%s: there is a file already; dump to a new folder, or delete it", path);
    return kd_file_out_open(&d->file, path);
}

void dump_row(dump *d, const void *row, size_t size)
{
    d->rows += fwrite(row, size, 1, d->file.stream);
}

kd_status dump_end(dump *d, const char *name, const dump_column *columns)
{
    kd_json *j = &d->tables;
    kd_status status = kd_file_out_commit(&d->file);
    if (status != KD_OK)
        return status;
    kd_json_object_begin(j);
    kd_json_key(j, "file");
    kd_json_string(j, name);
    kd_json_key(j, "rows");
    kd_json_uint(j, d->rows);
    kd_json_key(j, "columns");
    kd_json_array_begin(j);
    for (; columns->name; columns++) {
        kd_json_array_begin(j);
        kd_json_string(j, columns->name);
        kd_json_string(j, columns->type);
        kd_json_array_end(j);
    }
    kd_json_array_end(j);
    kd_json_object_end(j);
    return KD_OK;
}

void *dump_read(const dump *d, kd_gpu_buffer buffer, size_t offset, size_t size)
{
    void *data = malloc(size ? size : 1);
    if (!data) {
        (void)kd_fail(KD_NO_MEMORY, "--dump: out of memory for %zu bytes; take a coarser voxels.span", size);
        return NULL;
    }
    if (size)
        kd_gpu_read_buffer(d->rig->gpu, buffer, offset, data, size);
    return data;
}

/* ---- the index ---- */

static void put_uint(kd_json *j, const char *key, uint64_t value)
{
    kd_json_key(j, key);
    kd_json_uint(j, value);
}

static void put_cascade(kd_json *j, const kd_voxel_scene *scene, uint32_t c)
{
    const kd_vec3 *o = &scene->origin_ws[c];
    kd_json_object_begin(j);
    kd_json_key(j, "span_m");
    kd_json_double(j, (double)scene->span[c]);
    put_uint(j, "resolution", scene->resolution);
    kd_json_key(j, "origin_cells");
    kd_json_array_begin(j);
    for (int k = 0; k < 3; k++)
        kd_json_int(j, scene->origin_cells[c][k]);
    kd_json_array_end(j);
    kd_json_key(j, "origin_m");
    kd_json_array_begin(j);
    kd_json_double(j, (double)o->x);
    kd_json_double(j, (double)o->y);
    kd_json_double(j, (double)o->z);
    kd_json_array_end(j);
    kd_json_object_end(j);
}

static kd_status write_index(const dump *d)
{
    char path[KD_PATH_MAX];
    const kd_voxel_scene *scene = kd_singleton(d->rig->world, kd_voxel_scene);
    const kd_svo *svo = kd_singleton(d->rig->world, kd_svo);
    const char *tables = kd_json_text(&d->tables), *text;
    kd_json head = {.indent = 1};
    kd_json_object_begin(&head);
    put_uint(&head, "version", DUMP_VERSION);
    kd_json_key(&head, "scene");
    kd_json_string(&head, d->rig->options.subject);
    put_uint(&head, "frames", d->rig->frame);
    put_uint(&head, "levels", svo->leaf_level - KD_DENSE_LOG2);
    kd_json_key(&head, "full_depth");
    kd_json_double(&head, KD_FULL_DEPTH);
    kd_json_key(&head, "cascades");
    kd_json_array_begin(&head);
    for (uint32_t c = 0; c < scene->cascade_count; c++)
        put_cascade(&head, scene, c);
    kd_json_array_end(&head);
    text = kd_json_text(&head);
    kd_status status = kd_path_join(path, sizeof path, d->folder, INDEX);
    size_t size = text && tables ? strlen(text) + strlen(tables) + 32 : 0;
    char *whole = size ? malloc(size) : NULL;
    if (!whole)
        status = kd_fail(KD_NO_MEMORY, "%s: out of memory", path);
    else if (status == KD_OK) {
        int length = snprintf(whole, size, "%s,\n \"tables\": %s\n}", text, tables);
        status = kd_file_write(path, whole, (size_t)length);
    }
    free(whole);
    kd_json_fini(&head);
    return status;
}

/* An index of an earlier dump would claim tables that are not its own. */
static kd_status check_folder(const dump *d)
{
    char path[KD_PATH_MAX];
    struct stat info;
    if (stat(d->folder, &info) == 0 && !S_ISDIR(info.st_mode))
        return kd_fail(KD_UNSUPPORTED, "--dump: %s: is a file; name a folder", d->folder);
    kd_status status = kd_folder_make(d->folder);
    if (status == KD_OK)
        status = kd_path_join(path, sizeof path, d->folder, INDEX);
    if (status == KD_OK && lstat(path, &info) == 0)
        return kd_fail(KD_IO, "%s: a dump is here already; dump to a new folder, or delete it", path);
    return status;
}

kd_status dump_write(const rig *r, const char *folder)
{
    static kd_status (*const parts[])(dump *) = {dump_leaves, dump_nodes, dump_pages, dump_caches,
                                                 dump_objects};
    dump d = {.rig = r, .folder = folder, .tables = {.indent = 1}};
    if (!kd_singleton(r->world, kd_svo)->masks.id)
        return kd_fail(KD_UNSUPPORTED, "--dump: this scene has no tree; it needs indirect light and voxels");
    kd_status status = check_folder(&d);
    kd_gpu_barrier(r->gpu, KD_BARRIER_BUFFER_UPDATE | KD_BARRIER_TEXTURE_UPDATE);
    kd_json_array_begin(&d.tables);
    for (size_t i = 0; i < sizeof parts / sizeof *parts && status == KD_OK; i++)
        status = parts[i](&d);
    kd_json_array_end(&d.tables);
    if (status == KD_OK)
        status = kd_gpu_failed(r->gpu) ? KD_GPU : write_index(&d);
    kd_json_fini(&d.tables);
    return status;
}
