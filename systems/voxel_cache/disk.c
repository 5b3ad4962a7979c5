#include "systems/voxel_cache/disk.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <xxhash.h>

#include "runtime/core/log.h"

/* The folder is cut to three quarters of this when it has grown beyond. */
#define MOST_BYTES (1ull << 30)

static bool use_folder(voxel_disk *disk, const char *base, const char *below)
{
    int length = base && *base ? snprintf(disk->folder, sizeof disk->folder, "%s%s", base, below) : -1;
    bool fits = length >= 0 && (size_t)length + 64 < sizeof disk->folder;
    if (!fits)
        disk->folder[0] = '\0';
    return fits;
}

void disk_init(voxel_disk *disk, const kd_gpu_info *driver)
{
    disk->driver =
        XXH64(driver->version, strlen(driver->version), XXH64(driver->renderer, strlen(driver->renderer), 0));
    if (getenv("KANDIL_CACHE"))
        use_folder(disk, getenv("KANDIL_CACHE"), "");
    else if (!use_folder(disk, getenv("XDG_CACHE_HOME"), "/kandil/voxels"))
        use_folder(disk, getenv("HOME"), "/.cache/kandil/voxels");
}

static void path_of(const voxel_disk *disk, kd_voxel_key key, char out[KD_PATH_MAX])
{
    size_t length = strlen(disk->folder);
    memcpy(out, disk->folder, length);
    snprintf(out + length, KD_PATH_MAX - length, "/%016llx%016llx-%08x.kvox", (unsigned long long)key.high,
             (unsigned long long)key.low, (unsigned)(disk->driver & 0xFFFFFFFFu));
}

bool disk_open(const voxel_disk *disk, kd_voxel_key key, kd_voxel_file *file)
{
    char path[KD_PATH_MAX], why[KD_VOXEL_WHY];
    if (!disk->folder[0])
        return false;
    path_of(disk, key, path);
    kd_status status = kd_voxel_file_open(file, path, why);
    if (status == KD_OK && kd_voxel_file_find(file, key)) {
        utimensat(AT_FDCWD, path, NULL, 0); /* in use: see disk_fini */
        return true;
    }
    if (status != KD_NOT_FOUND)
        kd_log(KD_LOG_INFO, "%s: %s; it is made anew", path,
               status ? why : "it is stale: it holds other voxels");
    kd_voxel_file_close(file);
    return false;
}

static void give_up(voxel_disk *disk)
{
    if (!disk->broken)
        kd_log(KD_LOG_WARNING, "%s: voxels cannot be kept there: %s; the next start makes them again",
               disk->folder, strerror(errno));
    disk->broken = true;
}

static bool make_folder(const char *path)
{
    char part[KD_PATH_MAX];
    snprintf(part, sizeof part, "%s", path);
    for (char *p = part + 1; *p; p++)
        if (*p == '/') {
            *p = '\0';
            mkdir(part, 0777);
            *p = '/';
        }
    return mkdir(part, 0777) == 0 || errno == EEXIST;
}

static bool write_all(int fd, const void *bytes, size_t size)
{
    for (size_t done = 0; done < size;) {
        ssize_t n = write(fd, (const char *)bytes + done, size - done);
        if (n < 0 && errno != EINTR)
            return false;
        done += n > 0 ? (size_t)n : 0;
    }
    return true;
}

void disk_save(voxel_disk *disk, kd_voxel_key key, const void *bytes, size_t size)
{
    char path[KD_PATH_MAX], temp[KD_PATH_MAX + 32];
    if (!disk->folder[0] || disk->broken)
        return;
    path_of(disk, key, path);
    snprintf(temp, sizeof temp, "%s.%ld.tmp", path, (long)getpid());
    int fd = make_folder(disk->folder) ? open(temp, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : -1;
    bool written = fd >= 0 && write_all(fd, bytes, size);
    int why = errno;
    if (fd >= 0 && close(fd) != 0 && written) {
        written = false;
        why = errno;
    }
    if (written && rename(temp, path) == 0) {
        disk->written += size;
        return;
    }
    why = written ? errno : why;
    if (fd >= 0)
        unlink(temp);
    errno = why;
    give_up(disk);
}

/* ---- keeping the folder small ---- */

typedef struct kept_file {
    char name[48];
    struct timespec used;
    uint64_t bytes;
} kept_file;

static int older_first(const void *left, const void *right)
{
    const kept_file *a = left, *b = right;
    if (a->used.tv_sec != b->used.tv_sec)
        return a->used.tv_sec < b->used.tv_sec ? -1 : 1;
    return (a->used.tv_nsec > b->used.tv_nsec) - (a->used.tv_nsec < b->used.tv_nsec);
}

/* As path_of names files: what people put there under other names is left alone. */
static bool is_ours(const char *name)
{
    return strspn(name, "0123456789abcdef") == 32 && name[32] == '-' &&
           strspn(name + 33, "0123456789abcdef") == 8 && strcmp(name + 41, ".kvox") == 0;
}

/* Files of ours in the folder; the caller frees them. */
static kept_file *list_files(DIR *folder, size_t *count, uint64_t *bytes)
{
    kept_file *files = NULL;
    size_t capacity = 0;
    *count = 0;
    *bytes = 0;
    for (const struct dirent *entry; (entry = readdir(folder));) {
        struct stat info;
        if (!is_ours(entry->d_name) ||
            fstatat(dirfd(folder), entry->d_name, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(info.st_mode))
            continue;
        if (*count == capacity) {
            capacity = capacity ? capacity * 2 : 256;
            kept_file *grown = realloc(files, capacity * sizeof *grown);
            if (!grown)
                break;
            files = grown;
        }
        kept_file *file = &files[(*count)++];
        memcpy(file->name, entry->d_name, strlen(entry->d_name) + 1);
        file->used = info.st_mtim;
        file->bytes = (uint64_t)info.st_size;
        *bytes += file->bytes;
    }
    return files;
}

void disk_fini(voxel_disk *disk)
{
    size_t count;
    uint64_t bytes;
    DIR *folder = disk->written && disk->folder[0] ? opendir(disk->folder) : NULL;
    if (!folder)
        return;
    kept_file *files = list_files(folder, &count, &bytes);
    if (bytes > MOST_BYTES)
        qsort(files, count, sizeof *files, older_first);
    for (size_t i = 0; bytes > MOST_BYTES && i < count; i++) {
        unlinkat(dirfd(folder), files[i].name, 0);
        files[i].bytes = files[i].bytes < bytes ? files[i].bytes : bytes;
        bytes -= files[i].bytes;
        if (bytes <= MOST_BYTES / 4 * 3)
            break;
    }
    free(files);
    closedir(folder);
}
