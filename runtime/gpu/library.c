#include "runtime/gpu/context.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

void *gpu_library_open(const char *const *names, gpu_reason *reason)
{
    for (const char *const *name = names; *name; name++) {
        void *library = dlopen(*name, RTLD_NOW | RTLD_LOCAL);
        if (library)
            return library;
    }
    const char *text = dlerror();
    snprintf(reason->text, sizeof reason->text, "%s is missing (%s)", names[0], text ? text : "not found");
    return NULL;
}

bool gpu_library_load(void *library, const gpu_symbol *symbols, size_t count, void *table, gpu_reason *reason)
{
    for (size_t i = 0; i < count; i++) {
        void *address = dlsym(library, symbols[i].name);
        if (!address) {
            snprintf(reason->text, sizeof reason->text, "the library lacks %s", symbols[i].name);
            return false;
        }
        memcpy((char *)table + symbols[i].offset, &address, sizeof address);
    }
    return true;
}
