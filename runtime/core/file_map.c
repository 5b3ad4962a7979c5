#include "runtime/core/file_map.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static kd_status map_file(kd_file_map *map, int fd)
{
    struct stat info;
    if (fstat(fd, &info) != 0)
        return KD_IO;
    if (!S_ISREG(info.st_mode))
        return KD_UNSUPPORTED;
    if (info.st_size == 0)
        return KD_OK;
    void *data = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return errno == ENOMEM ? KD_NO_MEMORY : KD_IO;
    *map = (kd_file_map){data, (size_t)info.st_size};
    return KD_OK;
}

kd_status kd_file_map_open(kd_file_map *map, const char *path)
{
    *map = (kd_file_map){0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* not to wait for the writer of a pipe */
    if (fd < 0)
        return errno == ENOENT || errno == ENOTDIR ? KD_NOT_FOUND
               : errno == EACCES || errno == EPERM ? KD_NO_PERMISSION
                                                   : KD_IO;
    kd_status status = map_file(map, fd);
    close(fd);
    return status;
}

void kd_file_map_close(kd_file_map *map)
{
    if (map->data)
        munmap((void *)(size_t)map->data, map->size);
    *map = (kd_file_map){0};
}
