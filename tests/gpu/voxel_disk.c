/* The second start finds on disk what the first has made; files that are cut, damaged, foreign or stale are
 * made anew, and a folder that cannot be written costs a warning. */

#include "tests/voxel_fixture.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include "runtime/asset/voxel_file.h"

static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/kandil-voxels-XXXXXX");
    if (!mkdtemp(folder))
        return -1;
    setenv("KANDIL_CACHE", folder, 1);
    return 0;
}

/* Call fn for every file of the folder; returns how many there are. */
static uint32_t each_file(void (*fn)(const char *path))
{
    DIR *d = opendir(folder);
    uint32_t count = 0;
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d));) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (e->d_name[0] == '.')
            continue;
        count++;
        if (fn)
            fn(path);
    }
    closedir(d);
    return count;
}

static void remove_file(const char *path)
{
    unlink(path);
}

static int drop_folder(void **state)
{
    (void)state;
    chmod(folder, 0700);
    each_file(remove_file);
    unsetenv("KANDIL_CACHE");
    return rmdir(folder);
}

/* Shapes and a character in a world; everything that the cache holds, by value. */
typedef struct contents {
    uint32_t *shape, *color, *binding;
    uint64_t voxels, bindings;
    uint32_t caches;
} contents;

static contents run_world(float size)
{
    contents c;
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.12f});
    v.frame->settings.voxels_cache = true;
    voxel_shape(&v, KD_SHAPE_TORUS, (kd_vec3){size, 0.3f, 0}, NULL, voxel_at(0.013f, 0, 0));
    voxel_spawn(&v, fixture_character(2, 60, 9, 0, 3), voxel_at(0, 1, 0));
    voxel_spawn(&v, fixture_character(1, 40, 4, 2, 5), voxel_at(1, 1, 0));
    voxel_frame(&v);
    const kd_voxel_scene *s = voxel_scene(&v);
    c.voxels = s->voxel_places.end;
    c.bindings = s->binding_places.end;
    c.caches = s->cache_count;
    c.shape = voxel_read(s->cache_shape, 0, c.voxels * 8);
    c.color = voxel_read(s->cache_color, 0, c.voxels * 4);
    c.binding = voxel_read(s->cache_binding, 0, c.bindings * KD_BINDING_WORDS * 4);
    for (uint32_t i = 0; i < s->cache_count; i++)
        assert_true(s->caches[i].made);
    voxel_close(&v);
    return c;
}

static void drop(contents *c)
{
    free(c->shape);
    free(c->color);
    free(c->binding);
}

static void assert_same(contents *a, contents *b)
{
    assert_int_equal(a->voxels, b->voxels);
    assert_int_equal(a->bindings, b->bindings);
    assert_memory_equal(a->shape, b->shape, a->voxels * 8);
    assert_memory_equal(a->color, b->color, a->voxels * 4);
    assert_memory_equal(a->binding, b->binding, a->bindings * KD_BINDING_WORDS * 4);
}

/* Give every file a mark that only a rewrite takes away. */
static void make_old(const char *path)
{
    chmod(path, 0604);
}

static uint32_t old_files;
static void count_old(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    old_files += (info.st_mode & 0777) == 0604;
}

static uint32_t kept_files(void)
{
    old_files = 0;
    each_file(count_old);
    return old_files;
}

static void second_start_reads_what_the_first_has_made(void **state)
{
    (void)state;
    contents first = run_world(0.8f);
    uint32_t files = each_file(make_old);
    assert_true(first.voxels > 1000 && first.bindings > 100);
    assert_int_equal(files, first.caches);
    contents second = run_world(0.8f);
    assert_same(&first, &second);
    assert_int_equal(kept_files(), files);
    contents other = run_world(0.9f); /* another torus: its levels are new, the characters' are not */
    assert_int_equal(kept_files(), files);
    assert_true(each_file(NULL) > files && each_file(NULL) < 2 * files);
    drop(&first);
    drop(&second);
    drop(&other);
}

static void cut_in_half(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(truncate(path, info.st_size / 2), 0);
}

static void flip_a_bit(const char *path)
{ /* right behind the header: in a block */
    FILE *f = fopen(path, "r+b");
    assert_non_null(f);
    fseek(f, 70, SEEK_SET);
    int byte = fgetc(f);
    fseek(f, 70, SEEK_SET);
    fputc(byte ^ 16, f);
    fclose(f);
}

static void write_foreign(const char *path)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    for (int i = 0; i < 500; i++)
        fputs("not voxels ", f);
    fclose(f);
}

static void write_stale(const char *path)
{ /* sound, but of something else */
    kd_voxel_writer w = {0};
    size_t size;
    assert_int_equal(kd_voxel_writer_level(&w, &(kd_voxel_level){.key = {1, 2}, .span = 1}), KD_OK);
    const void *bytes = kd_voxel_writer_finish(&w, &size);
    FILE *f = fopen(path, "wb");
    assert_true(f && fwrite(bytes, 1, size, f) == size);
    fclose(f);
    kd_voxel_writer_fini(&w);
}

static void files_that_do_not_serve_are_made_anew(void **state)
{
    (void)state;
    void (*const harms[])(const char *) = {cut_in_half, flip_a_bit, write_foreign, write_stale};
    contents first = run_world(0.8f);
    for (size_t i = 0; i < sizeof harms / sizeof *harms; i++) {
        each_file(harms[i]);
        each_file(make_old);
        contents again = run_world(0.8f);
        assert_same(&first, &again);
        assert_int_equal(kept_files(), 0);
        each_file(make_old);
        contents third = run_world(0.8f);
        assert_same(&first, &third);
        assert_int_equal(kept_files(), first.caches);
        drop(&again);
        drop(&third);
    }
    drop(&first);
}

/* Area of what glows in all voxels of a box. */
static uint32_t glowing_area(float emission)
{
    voxel_world v = voxel_open((voxel_options){.cascades = 1, .span = 0.12f});
    kd_material_desc material = voxel_matte(0.5f, 0.5f, 0.5f);
    uint32_t sum = 0;
    material.emissive = (kd_vec3){emission, emission, emission};
    v.frame->settings.voxels_cache = true;
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &material, voxel_at(0, 0, 0));
    voxel_frame(&v);
    const uint64_t count = voxel_scene(&v)->voxel_places.end;
    uint32_t *color = voxel_read(voxel_scene(&v)->cache_color, 0, count * 4);
    for (uint64_t i = 0; i < count; i++)
        sum += color[i] >> 25;
    free(color);
    voxel_close(&v);
    return sum;
}

/* A lamp that was off when its voxels were kept has none of the areas by which it lights. */
static void what_glows_is_not_what_was_dark(void **state)
{
    (void)state;
    assert_int_equal(glowing_area(0), 0);
    uint32_t lit = glowing_area(2);
    assert_true(lit > 100);
    assert_int_equal(glowing_area(5), lit); /* how brightly is not in the voxels */
    assert_int_equal(each_file(NULL), 2);
}

static void folder_that_cannot_be_written_costs_one_warning(void **state)
{
    (void)state;
    char blocked[96];
    snprintf(blocked, sizeof blocked, "%s/file", folder);
    fclose(fopen(blocked, "wb"));
    setenv("KANDIL_CACHE", blocked, 1); /* not a folder: not even root can write below it */
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.12f});
    v.frame->settings.voxels_cache = true;
    voxel_shape(&v, KD_SHAPE_TORUS, (kd_vec3){0.8f, 0.3f, 0}, NULL, voxel_at(0, 0, 0));
    voxel_frame(&v);
    assert_true(voxel_scene(&v)->cached_voxels > 100);
    assert_non_null(strstr(voxel_warnings, "cannot be kept"));
    assert_ptr_equal(strchr(voxel_warnings, '\n'), voxel_warnings + strlen(voxel_warnings) - 1);
    voxel_warnings[0] = '\0';
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(second_start_reads_what_the_first_has_made, make_folder, drop_folder),
        cmocka_unit_test_setup_teardown(files_that_do_not_serve_are_made_anew, make_folder, drop_folder),
        cmocka_unit_test_setup_teardown(what_glows_is_not_what_was_dark, make_folder, drop_folder),
        cmocka_unit_test_setup_teardown(folder_that_cannot_be_written_costs_one_warning, make_folder,
                                        drop_folder),
    };
    return VOXEL_GROUP(tests);
}
