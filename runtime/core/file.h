#ifndef KD_CORE_FILE_H
#define KD_CORE_FILE_H

/* Whole files in, whole files out. Every failing call writes one message that names the path, and returns a
 * status. */

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "runtime/core/status.h"

#define KD_FILE_NO_LIMIT ((size_t)-1)
#define KD_PATH_MAX      4096

/* ---- reading ---- */

/** Read a whole file. A zero byte follows the data, so that text can be used as a string.
 *
 *  Returns *data and *size (without the zero); NULL and 0 after an error
 *  Errors  NOT_FOUND, NO_PERMISSION, TOO_LARGE for more than limit_bytes, UNSUPPORTED for a folder or a
 *          device, NO_MEMORY, IO
 *  Owns    the caller frees *data with free()
 */
kd_status kd_file_read(const char *path, size_t limit_bytes, void **data, size_t *size);

/** Tell whether a plain file can be read at the path. Writes no message. */
bool kd_file_exists(const char *path);

/* ---- writing: a file appears whole or not at all ---- */

/* A file being written: `stream` goes to a temporary file beside the path, which a commit renames. An
 * existing special file (/dev/stdout) is written directly. */
typedef struct kd_file_out {
    FILE *stream;
    char path[KD_PATH_MAX];
    char temp[KD_PATH_MAX]; /* "": written directly */
} kd_file_out;

/** Start a file; its folder must exist.
 *  Errors  NOT_FOUND, NO_PERMISSION, DISK_FULL, UNSUPPORTED for a folder, IO */
kd_status kd_file_out_open(kd_file_out *out, const char *path);
/** Finish: the whole file stands under its name, or an error is returned and nothing is left.
 *  Errors  DISK_FULL, IO */
kd_status kd_file_out_commit(kd_file_out *out);
/** Give up: nothing is left. Does nothing after a commit or a failed open. */
void kd_file_out_cancel(kd_file_out *out);

/** Write a whole file at once. Errors as open and commit. */
kd_status kd_file_write(const char *path, const void *data, size_t size);

/** Make a folder and those above it that are missing. One that exists is fine. */
kd_status kd_folder_make(const char *path);

/* ---- paths ---- */

/** Join; an absolute `name` stands alone, as does one in the folder ".".
 *  Errors OUT_OF_RANGE if it does not fit; out is then "" */
kd_status kd_path_join(char *out, size_t out_size, const char *folder, const char *name);
/** Copy the folder part: "a/b.c" gives "a", "b.c" gives ".", "/b" gives "/". Errors OUT_OF_RANGE. */
kd_status kd_path_folder(char *out, size_t out_size, const char *path);
/** Point at the last part of the path: "a/b.c" gives "b.c". */
const char *kd_path_name(const char *path);
/** Point at the extension with its dot: "a/b.tar.gz" gives ".gz"; "" when there is none. */
const char *kd_path_extension(const char *path);
/** Compare the extension without regard to case: kd_path_has_extension("A.PNG", ".png"). */
bool kd_path_has_extension(const char *path, const char *extension);

/** Tell whether the path lies in the folder or below it once every link and ".." is resolved. A path whose
 * end does not exist yet is judged by the part that does; false when the folder itself does not exist. */
bool kd_path_is_below(const char *folder, const char *path);

#endif
