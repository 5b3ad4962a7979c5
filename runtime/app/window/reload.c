#include "runtime/app/window/reload.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "runtime/core/file.h"
#include "runtime/core/log.h"

/* Whoever saves several files, or one in parts, has finished when nothing came for so long. */
#define QUIET_S 0.05

enum { MAX_ENTRIES = 1024, MAX_DEPTH = 8 };

typedef struct watch_entry {
    int folder; /* inotify's number */
    char *name; /* NULL: every file */
    window_change change;
} watch_entry;

struct window_watch {
    int inotify;
    watch_entry entries[MAX_ENTRIES];
    uint32_t entry_count;
    uint32_t changes;
    double changed_s;
};

window_watch *window_watch_make(void)
{
    window_watch *w = calloc(1, sizeof *w);
    if (!w)
        return NULL;
    w->inotify = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    if (w->inotify >= 0)
        return w;
    kd_log(KD_LOG_WARNING, "changed files are not noticed (%s); press F5 to load the scene anew",
           strerror(errno));
    free(w);
    return NULL;
}

/* Folders stay watched, and have their number again when they are added again: what happens in between is
 * not lost, and what happens in those that are not is passed over. */
void window_watch_clear(window_watch *w)
{
    for (uint32_t i = 0; w && i < w->entry_count; i++)
        free(w->entries[i].name);
    if (w)
        w->entry_count = 0;
}

void window_watch_destroy(window_watch *w)
{
    if (!w)
        return;
    window_watch_clear(w);
    close(w->inotify);
    free(w);
}

static bool is_watched(const window_watch *w, int folder, const char *name, window_change change)
{
    for (uint32_t i = 0; i < w->entry_count; i++) {
        const watch_entry *e = &w->entries[i];
        bool same_name = e->name && name ? strcmp(e->name, name) == 0 : e->name == name;
        if (e->folder == folder && e->change == change && same_name)
            return true;
    }
    return false;
}

static void add(window_watch *w, const char *folder, const char *name, window_change change)
{
    if (w->entry_count == MAX_ENTRIES)
        return;
    int number = inotify_add_watch(w->inotify, folder, IN_CLOSE_WRITE | IN_MOVED_TO);
    if (is_watched(w, number, name, change))
        return;
    char *copy = name ? strdup(name) : NULL;
    if (number >= 0 && (copy || !name))
        w->entries[w->entry_count++] = (watch_entry){number, copy, change};
    else
        free(copy);
}

void window_watch_file(window_watch *w, const char *path, window_change change)
{
    char folder[KD_PATH_MAX];
    if (w && kd_path_folder(folder, sizeof folder, path) == KD_OK)
        add(w, folder, kd_path_name(path), change);
}

static void watch_below(window_watch *w, const char *folder, window_change change, int depth)
{
    char path[KD_PATH_MAX];
    DIR *dir = opendir(folder);
    add(w, folder, NULL, change);
    for (struct dirent *entry; dir && depth < MAX_DEPTH && (entry = readdir(dir)) != NULL;)
        if (entry->d_type == DT_DIR && entry->d_name[0] != '.' &&
            kd_path_join(path, sizeof path, folder, entry->d_name) == KD_OK)
            watch_below(w, path, change, depth + 1);
    if (dir)
        closedir(dir);
}

void window_watch_tree(window_watch *w, const char *folder, window_change change)
{
    if (w)
        watch_below(w, folder, change, 0);
}

static bool fits(const watch_entry *entry, const struct inotify_event *event)
{
    if (entry->folder != event->wd || !event->len)
        return false;
    return !entry->name || strcmp(entry->name, event->name) == 0;
}

uint32_t window_watch_poll(window_watch *w, double now_s)
{
    _Alignas(struct inotify_event) char buffer[4096];
    ssize_t size;
    if (!w)
        return 0;
    while ((size = read(w->inotify, buffer, sizeof buffer)) > 0) {
        const struct inotify_event *event;
        for (char *p = buffer; p < buffer + size; p += sizeof *event + event->len) {
            event = (const struct inotify_event *)(const void *)p;
            for (uint32_t i = 0; i < w->entry_count; i++) {
                if (!fits(&w->entries[i], event))
                    continue;
                w->changes |= w->entries[i].change;
                w->changed_s = now_s;
            }
        }
    }
    if (!w->changes || now_s < w->changed_s + QUIET_S)
        return 0;
    uint32_t changes = w->changes;
    w->changes = 0;
    return changes;
}
