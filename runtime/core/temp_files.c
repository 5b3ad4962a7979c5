/* A list of fixed size, since a signal handler may take no lock and allocate nothing. */
#include "runtime/core/temp_files.h"

#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/file.h"

enum { FREE, BEING_WRITTEN, KNOWN, MAX_FILES = 32 };

static struct {
    atomic_int state;
    char path[KD_PATH_MAX];
} files[MAX_FILES];

void kd_temp_files_add(const char *path)
{
    if (strlen(path) >= sizeof files[0].path)
        return;
    for (int i = 0; i < MAX_FILES; i++) {
        int expected = FREE;
        if (!atomic_compare_exchange_strong(&files[i].state, &expected, BEING_WRITTEN))
            continue;
        memcpy(files[i].path, path, strlen(path) + 1);
        atomic_store(&files[i].state, KNOWN);
        return;
    }
}

void kd_temp_files_forget(const char *path)
{
    for (int i = 0; i < MAX_FILES; i++)
        if (atomic_load(&files[i].state) == KNOWN && strcmp(files[i].path, path) == 0)
            atomic_store(&files[i].state, FREE);
}

void kd_temp_files_remove(void)
{
    for (int i = 0; i < MAX_FILES; i++)
        if (atomic_load(&files[i].state) == KNOWN)
            unlink(files[i].path);
}
