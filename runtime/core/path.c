#include "runtime/core/file.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "runtime/core/log.h"

static kd_status put(char *out, size_t out_size, const char *a, size_t a_length, const char *separator,
                     const char *b)
{
    size_t separator_length = strlen(separator), b_length = strlen(b);
    if (out_size)
        out[0] = '\0';
    if (a_length + separator_length + b_length >= out_size)
        return kd_fail(KD_OUT_OF_RANGE, "%.40s...: the path is too long (%zu bytes); use a shorter one", a,
                       a_length + separator_length + b_length);
    memcpy(out, a, a_length);
    memcpy(out + a_length, separator, separator_length);
    memcpy(out + a_length + separator_length, b, b_length + 1);
    return KD_OK;
}

kd_status kd_path_join(char *out, size_t out_size, const char *folder, const char *name)
{
    size_t length = strlen(folder);
    if (name[0] == '/' || length == 0 || (name[0] && strcmp(folder, ".") == 0))
        return put(out, out_size, name, strlen(name), "", "");
    return put(out, out_size, folder, length, folder[length - 1] == '/' || !name[0] ? "" : "/", name);
}

kd_status kd_path_folder(char *out, size_t out_size, const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return put(out, out_size, ".", 1, "", "");
    while (slash > path && slash[-1] == '/')
        slash--;
    return put(out, out_size, path, slash == path ? 1 : (size_t)(slash - path), "", "");
}

const char *kd_path_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

const char *kd_path_extension(const char *path)
{
    const char *name = kd_path_name(path);
    const char *dot = strrchr(name, '.');
    return dot && dot != name ? dot : name + strlen(name);
}

bool kd_path_has_extension(const char *path, const char *extension)
{
    return strcasecmp(kd_path_extension(path), extension) == 0;
}

/* Resolve the longest part of the path that exists. False when what follows it climbs up again: no one can
 * tell where. */
static bool resolve_existing(const char *path, char resolved[PATH_MAX])
{
    char rest[KD_PATH_MAX];
    if (strlen(path) >= sizeof rest)
        return false;
    strcpy(rest, path);
    for (;;) {
        if (realpath(rest[0] ? rest : ".", resolved))
            return true;
        if (errno != ENOENT || !rest[0])
            return false;
        size_t length = strlen(rest);
        while (length > 1 && rest[length - 1] == '/')
            rest[--length] = '\0';
        char *name = rest + (kd_path_name(rest) - rest);
        if (strcmp(name, "..") == 0)
            return false;
        *name = '\0';
    }
}

bool kd_path_is_below(const char *folder, const char *path)
{
    char top[PATH_MAX], inner[PATH_MAX];
    if (!realpath(folder, top) || !resolve_existing(path, inner))
        return false;
    size_t length = strlen(top);
    if (length == 1)
        return true; /* everything is below "/" */
    return strncmp(top, inner, length) == 0 && (inner[length] == '\0' || inner[length] == '/');
}
