#include "runtime/gpu/source.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/embedded.h"

enum { MAX_DEPTH = 16, MAX_FILE_BYTES = 4 << 20 };

/* ---- the text ---- */

static bool append(gpu_source *source, const char *text, size_t size)
{
    if (source->size + size + 1 > source->capacity) {
        size_t capacity = (source->size + size + 1) * 2;
        char *grown = realloc(source->text, capacity);
        if (!grown) {
            snprintf(source->error, sizeof source->error, "no memory for the source of a shader");
            return false;
        }
        source->text = grown;
        source->capacity = capacity;
    }
    memcpy(source->text + source->size, text, size);
    source->size += size;
    source->text[source->size] = '\0';
    return true;
}

static bool append_text(gpu_source *source, const char *text)
{
    return append(source, text, strlen(text));
}

static bool append_line_number(gpu_source *source, unsigned line, unsigned file)
{
    char text[48];
    snprintf(text, sizeof text, "#line %u %u\n", line, file);
    return append_text(source, text);
}

/* ---- files ---- */

static char *read_from_folder(const char *folder, const char *path, size_t *size)
{
    char full[4096];
    if ((size_t)snprintf(full, sizeof full, "%s/%s", folder, path) >= sizeof full)
        return NULL;
    FILE *file = fopen(full, "rb");
    if (!file)
        return NULL;
    size_t capacity = 1 << 16, used = 0, got;
    char *text = malloc(capacity);
    while (text && (got = fread(text + used, 1, capacity - used, file)) > 0) {
        used += got;
        if (used < capacity)
            continue;
        char *grown = capacity < MAX_FILE_BYTES ? realloc(text, capacity *= 2) : NULL;
        if (!grown)
            free(text);
        text = grown;
    }
    if (text && ferror(file)) {
        free(text);
        text = NULL;
    }
    fclose(file);
    *size = used;
    return text;
}

static const kd_embedded_shader *find_row(const kd_embedded_shader *rows, const char *path)
{
    for (; rows && rows->path; rows++)
        if (strcmp(rows->path, path) == 0)
            return rows;
    return NULL;
}

/* Returns the text of a file, which the caller frees; NULL when it is not there. */
static char *load(const gpu_source *source, const char *path, size_t *size)
{
    const char *folder = getenv("KANDIL_SHADER_DIR");
    bool outside = folder && *folder;
    char *copy = outside ? read_from_folder(folder, path, size) : NULL;
    const kd_embedded_shader *row = outside ? NULL : find_row(kd_embedded_shaders, path);
    if (!row)
        row = find_row(source->more, path);
    if (copy || !row)
        return copy;
    copy = malloc(row->size + 1);
    if (copy)
        memcpy(copy, row->text, row->size + 1);
    *size = row->size;
    return copy;
}

/* ---- includes ---- */

/* Parse `# include "PATH"`. Returns false for any other line; path is empty when it is malformed or in <>. */
static bool parse_include(const char *line, const char *end, char *path, size_t capacity)
{
    while (line < end && isblank((unsigned char)*line))
        line++;
    if (line == end || *line++ != '#')
        return false;
    while (line < end && isblank((unsigned char)*line))
        line++;
    if (end - line < 7 || strncmp(line, "include", 7) != 0)
        return false;
    line += 7;
    while (line < end && isblank((unsigned char)*line))
        line++;
    const char *close = line < end && *line == '"' ? memchr(line + 1, '"', (size_t)(end - line - 1)) : NULL;
    size_t length = close ? (size_t)(close - line - 1) : 0;
    if (length >= capacity)
        length = 0;
    memcpy(path, line + (close ? 1 : 0), length);
    path[length] = '\0';
    return true;
}

/* Follow block comments over one line, so that an include inside of one is left alone. */
static bool ends_in_comment(const char *line, const char *end, bool in_comment)
{
    for (; line + 1 < end; line++) {
        if (in_comment && line[0] == '*' && line[1] == '/') {
            in_comment = false;
            line++;
        } else if (!in_comment && line[0] == '/' && line[1] == '/') {
            return false;
        } else if (!in_comment && line[0] == '/' && line[1] == '*') {
            in_comment = true;
            line++;
        }
    }
    return in_comment;
}

static bool has_file(const gpu_source *source, const char *path)
{
    for (unsigned i = 0; i < source->path_count; i++)
        if (strcmp(source->paths[i], path) == 0)
            return true;
    return false;
}

static bool expand(gpu_source *source, const char *path, char *text, size_t size, unsigned depth);

/* Put the file of one include line in. */
static bool include(gpu_source *source, const char *path, unsigned file, unsigned line, unsigned depth)
{
    char message[512];
    size_t size = 0;
    if (has_file(source, path))
        return append_text(source, "\n");
    char *text = strncmp(path, "shaders/", 8) == 0 && depth < MAX_DEPTH ? load(source, path, &size) : NULL;
    if (text)
        return expand(source, path, text, size, depth + 1) && append_line_number(source, line + 1, file);
    snprintf(message, sizeof message, "#error cannot include %s: no such file under shaders\n",
             *path ? path : "it: the path must stand in quotes");
    return append_text(source, message);
}

static bool expand_lines(gpu_source *source, const char *text, size_t size, unsigned file, unsigned depth)
{
    const char *end = text + size;
    bool in_comment = false, good = append_line_number(source, 1, file);
    for (unsigned line = 1; good && text < end; line++) {
        char path[256];
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        const char *line_end = stop ? stop : end;
        if (!in_comment && parse_include(text, line_end, path, sizeof path))
            good = include(source, path, file, line, depth);
        else
            good = append(source, text, (size_t)(line_end - text)) && append_text(source, "\n");
        in_comment = ends_in_comment(text, line_end, in_comment);
        text = line_end + 1;
    }
    return good;
}

/* Takes `text` over. */
static bool expand(gpu_source *source, const char *path, char *text, size_t size, unsigned depth)
{
    bool good = false;
    unsigned file = source->path_count;
    char *copy = strdup(path);
    if (file == GPU_MAX_SOURCE_FILES || !copy || memchr(text, '\0', size)) {
        snprintf(source->error, sizeof source->error, "%.150s: %s", path,
                 !copy                          ? "out of memory"
                 : file == GPU_MAX_SOURCE_FILES ? "too many includes; put some together"
                                                : "the file is no text");
        free(copy);
    } else {
        source->paths[source->path_count++] = copy;
        good = expand_lines(source, text, size, file, depth);
    }
    free(text);
    return good;
}

bool gpu_source_expand(gpu_source *source, const char *path, const char *const *defines)
{
    size_t size = 0;
    bool good = append_text(source, "#version 450 core\n#define KD_GLSL 1\n");
    for (; good && defines && *defines; defines++)
        good = append_text(source, "#define ") && append_text(source, *defines) && append_text(source, "\n");
    if (!good)
        return false;
    char *text = load(source, path, &size);
    if (text)
        return expand(source, path, text, size, 0);
    const char *folder = getenv("KANDIL_SHADER_DIR");
    bool outside = folder && *folder;
    snprintf(source->error, sizeof source->error, "%.100s: no such shader (in %.80s); %s", path,
             outside ? folder : "the program", outside ? "check KANDIL_SHADER_DIR" : "check the path");
    return false;
}

void gpu_source_fini(gpu_source *source)
{
    for (unsigned i = 0; i < source->path_count; i++)
        free(source->paths[i]);
    free(source->text);
    *source = (gpu_source){0};
}

/* ---- messages ---- */

void gpu_source_translate(const gpu_source *source, const char *line, size_t length, char *out,
                          size_t capacity)
{
    char text[512];
    snprintf(text, sizeof text, "%.*s", (int)(length < sizeof text ? length : sizeof text - 1), line);
    /* Mesa: 0:12(5): error …; NVIDIA: 0(12) : error …; others: ERROR: 0:12: … */
    const char *start = text, *prefix = "";
    if (strncmp(start, "ERROR: ", 7) == 0) {
        start += 7;
        prefix = "error: ";
    }
    char *after = NULL;
    unsigned long file = isdigit((unsigned char)*start) ? strtoul(start, &after, 10) : GPU_MAX_SOURCE_FILES;
    bool found = after && (*after == ':' || *after == '(') && isdigit((unsigned char)after[1]);
    if (!found || file >= source->path_count) {
        snprintf(out, capacity, "%s", text);
        return;
    }
    unsigned long number = strtoul(after + 1, &after, 10);
    if (*after == '(') /* the column */
        after += strcspn(after, ")");
    while (*after == ')' || *after == ':' || *after == ' ')
        after++;
    snprintf(out, capacity, "%s:%lu: %s%s", source->paths[file], number, prefix, after);
}
