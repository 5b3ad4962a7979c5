/* Which files a scenario may name: those below its own folder or an asset root, links resolved. */
#include "runtime/script/internal.h"

#include <string.h>

static bool lies_in_roots(const kd_script *script, const char *path)
{
    for (uint32_t i = 0; i < script->root_count; i++)
        if (kd_path_is_below(script->roots[i], path))
            return true;
    return false;
}

const char *script_resolve(lua_State *L, const char *name, char out[KD_PATH_MAX])
{
    const kd_script *script = script_of(L);
    bool outside = false;
    for (uint32_t i = 0; i < script->root_count; i++) {
        if (kd_path_join(out, KD_PATH_MAX, script->roots[i], name) != KD_OK)
            luaL_error(L, "a path of %d characters is too long; shorten it", (int)strlen(name));
        if (!lies_in_roots(script, out)) { /* a link in one root may lead to another */
            outside = true;
            continue;
        }
        if (script->host.asked_for)
            script->host.asked_for(script->host.user, out);
        if (kd_file_exists(out))
            return out;
    }
    if (outside)
        luaL_error(L, "%s: lies outside the scenario's folder; give its folder with --asset-root", name);
    luaL_error(L, "%s: not found in %s; check the name, or add its folder with --asset-root", name,
               script->root_count > 1 ? "the scenario's folder and the asset roots"
                                      : "the scenario's folder");
    return NULL;
}
