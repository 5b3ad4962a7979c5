#include "runtime/core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "runtime/core/log.h"
#include "runtime/core/temp_files.h"

/* Turn errno into a status and one message. */
static kd_status fail_errno(const char *path, const char *action)
{
    switch (errno) {
    case ENOENT:
    case ENOTDIR:
        return kd_fail(KD_NOT_FOUND, "%s: no such file or folder (%s); check the path", path, action);
    case EACCES:
    case EPERM:
    case EROFS:
        return kd_fail(KD_NO_PERMISSION,
                       "%s: permission denied (%s); check the rights of the file and its folder", path,
                       action);
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
        return kd_fail(KD_DISK_FULL, "%s: no space left (%s); make room or choose another disk", path,
                       action);
    case ENXIO:
        return kd_fail(KD_IO, "%s: is a pipe that nobody reads (%s); start the reader first, or name a file",
                       path, action);
    case ENAMETOOLONG:
        return kd_fail(KD_OUT_OF_RANGE, "%s: the name is too long (%s); use a shorter one", path, action);
    case ENOMEM: return kd_fail(KD_NO_MEMORY, "%s: out of memory (%s)", path, action);
    default: return kd_fail(KD_IO, "%s: %s (%s)", path, strerror(errno), action);
    }
}

/* ---- reading ---- */

static kd_status check_readable(const char *path, int fd, size_t limit_bytes, size_t *size)
{
    struct stat info;
    if (fstat(fd, &info) != 0)
        return fail_errno(path, "reading");
    if (S_ISDIR(info.st_mode))
        return kd_fail(KD_UNSUPPORTED, "%s: is a folder (reading); name a file", path);
    if (!S_ISREG(info.st_mode))
        return kd_fail(KD_UNSUPPORTED, "%s: is a pipe or device (reading); name a plain file", path);
    if ((uintmax_t)info.st_size > limit_bytes)
        return kd_fail(KD_TOO_LARGE, "%s: has %jd bytes, at most %zu are taken (reading)", path,
                       (intmax_t)info.st_size, limit_bytes);
    *size = (size_t)info.st_size;
    return KD_OK;
}

static kd_status read_all(const char *path, int fd, size_t expected, void **data, size_t *size)
{
    unsigned char *bytes = expected < SIZE_MAX ? malloc(expected + 1) : NULL;
    if (!bytes)
        return kd_fail(KD_NO_MEMORY, "%s: no memory for its %zu bytes (reading)", path, expected);
    size_t done = 0;
    while (done < expected) {
        ssize_t got = read(fd, bytes + done, expected - done);
        if (got == 0)
            break; /* it shrank meanwhile: what was there is what we got */
        if (got > 0) {
            done += (size_t)got;
        } else if (errno != EINTR) {
            free(bytes);
            return fail_errno(path, "reading");
        }
    }
    bytes[done] = 0;
    *data = bytes;
    *size = done;
    return KD_OK;
}

kd_status kd_file_read(const char *path, size_t limit_bytes, void **data, size_t *size)
{
    *data = NULL;
    *size = 0;
    /* Not to wait for a writer when the path is a named pipe. */
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return fail_errno(path, "reading");
    size_t expected = 0;
    kd_status status = check_readable(path, fd, limit_bytes, &expected);
    if (status == KD_OK)
        status = read_all(path, fd, expected, data, size);
    close(fd);
    return status;
}

bool kd_file_exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode) && access(path, R_OK) == 0;
}

/* ---- writing ---- */

/* Choose the name of a temporary file that nobody else has, in the folder of the target so that rename stays
 * on one disk. */
static kd_status choose_temp(kd_file_out *out)
{
    static atomic_uint counter;
    char folder[KD_PATH_MAX], name[64];
    kd_status status = kd_path_folder(folder, sizeof folder, out->path);
    if (status != KD_OK)
        return status;
    snprintf(name, sizeof name, ".kandil-%ld-%u.tmp", (long)getpid(), atomic_fetch_add(&counter, 1));
    return kd_path_join(out->temp, sizeof out->temp, folder, name);
}

static void remove_temp(const kd_file_out *out)
{
    if (!out->temp[0])
        return;
    unlink(out->temp);
    kd_temp_files_forget(out->temp);
}

static kd_status open_stream(kd_file_out *out, const char *name, int flags, mode_t mode)
{
    /* Not to wait for a reader when it is a named pipe; from then on writing may well wait. */
    int fd = open(name, O_WRONLY | O_CLOEXEC | O_NONBLOCK | flags, 0666);
    if (fd >= 0)
        fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) & ~O_NONBLOCK);
    if (fd >= 0 && mode)
        fchmod(fd, mode);
    out->stream = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (out->stream)
        return KD_OK;
    kd_status status = fail_errno(out->path, "writing");
    if (fd >= 0)
        close(fd);
    if (fd >= 0)
        remove_temp(out);
    kd_temp_files_forget(out->temp);
    return status;
}

kd_status kd_file_out_open(kd_file_out *out, const char *path)
{
    *out = (kd_file_out){0};
    char resolved[PATH_MAX];
    struct stat info = {0};
    bool exists = stat(path, &info) == 0;
    /* The target of a link is replaced, not the link. */
    const char *target = exists && realpath(path, resolved) ? resolved : path;
    kd_status status = kd_path_join(out->path, sizeof out->path, "", target);
    if (status != KD_OK)
        return status;
    if (!path[0])
        return kd_fail(KD_NOT_FOUND, "the name of the file to write is empty; name a file");
    if (exists && S_ISDIR(info.st_mode))
        return kd_fail(KD_UNSUPPORTED, "%s: is a folder (writing); name a file", path);
    if (exists && access(path, W_OK) != 0)
        return fail_errno(path, "writing");
    if (exists && !S_ISREG(info.st_mode))
        return open_stream(out, path, 0, 0);
    status = choose_temp(out);
    if (status != KD_OK)
        return status;
    kd_temp_files_add(out->temp);
    return open_stream(out, out->temp, O_CREAT | O_EXCL, exists ? info.st_mode & 07777 : 0);
}

kd_status kd_file_out_commit(kd_file_out *out)
{
    FILE *stream = out->stream;
    out->stream = NULL;
    errno = 0;
    bool failed = fflush(stream) != 0 || ferror(stream);
    int first_error = errno;
    if (fclose(stream) != 0 && !failed) {
        failed = true;
        first_error = errno;
    }
    if (!failed && out->temp[0] && rename(out->temp, out->path) != 0) {
        failed = true;
        first_error = errno;
    }
    if (failed)
        remove_temp(out);
    else if (out->temp[0])
        kd_temp_files_forget(out->temp);
    if (!failed)
        return KD_OK;
    /* An earlier write may have failed with its errno forgotten; lack of space is by far the commonest cause.
     */
    errno = first_error ? first_error : ENOSPC;
    return fail_errno(out->path, "writing");
}

void kd_file_out_cancel(kd_file_out *out)
{
    if (!out->stream)
        return;
    fclose(out->stream);
    out->stream = NULL;
    remove_temp(out);
}

kd_status kd_file_write(const char *path, const void *data, size_t size)
{
    kd_file_out out;
    kd_status status = kd_file_out_open(&out, path);
    if (status != KD_OK)
        return status;
    errno = 0;
    if (fwrite(data, 1, size, out.stream) != size) {
        if (!errno)
            errno = ENOSPC;
        status = fail_errno(out.path, "writing");
        kd_file_out_cancel(&out);
        return status;
    }
    return kd_file_out_commit(&out);
}

static bool is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

kd_status kd_folder_make(const char *path)
{
    char part[KD_PATH_MAX];
    kd_status status = kd_path_join(part, sizeof part, "", path);
    if (status != KD_OK)
        return status;
    for (char *p = part;; p++) {
        if (*p != '/' && *p != '\0')
            continue;
        char kept = *p;
        *p = '\0';
        if (part[0] && mkdir(part, 0777) != 0 && !is_folder(part))
            return fail_errno(path, "making the folder");
        if (kept == '\0')
            return KD_OK;
        *p = kept;
    }
}
