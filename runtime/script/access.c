/* How a scenario reaches one field: found once by name, then kept. A name is a field of the component, one
 * number of a vector (position.x), an angle in degrees (fov_y_deg), or what a transform understands besides
 * its fields (rotation_deg, look_at). */
#include "runtime/script/internal.h"

#include <string.h>

#include "runtime/core/nearest.h"
#include "runtime/ecs/reflect.h"

#define DEG_PER_RAD 57.295779513082323

static const char access_key; /* its address keys the registry's table: description to (name to access) */

const kd_field *script_find_field(const kd_component_desc *desc, const char *name)
{
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (strcmp(desc->fields[i].name, name) == 0)
            return &desc->fields[i];
    return NULL;
}

bool script_is_angle(const kd_field *field)
{
    return field->type == KD_F32 && field->count <= 1 && field->unit && strcmp(field->unit, "rad") == 0;
}

/* "fov_y_deg" finds the field "fov_y" when that is an angle. */
static const kd_field *find_degrees(const kd_component_desc *desc, const char *name)
{
    size_t length = strlen(name);
    if (length < 5 || strcmp(name + length - 4, "_deg") != 0)
        return NULL;
    for (uint32_t i = 0; i < desc->field_count; i++) {
        const kd_field *f = &desc->fields[i];
        if (script_is_angle(f) && strlen(f->name) == length - 4 && strncmp(f->name, name, length - 4) == 0)
            return f;
    }
    return NULL;
}

static bool is_pose(const kd_component_desc *desc)
{
    return strcmp(desc->name, "transform") == 0;
}

static _Noreturn void unknown_field(lua_State *L, const kd_component_desc *desc, const char *name)
{
    kd_nearest near = kd_nearest_to(name);
    for (uint32_t i = 0; i < desc->field_count; i++) {
        kd_nearest_offer(&near, desc->fields[i].name);
        if (script_is_angle(&desc->fields[i]))
            kd_nearest_offer(&near, lua_pushfstring(L, "%s_deg", desc->fields[i].name));
    }
    if (is_pose(desc)) {
        kd_nearest_offer(&near, "rotation_deg");
        kd_nearest_offer(&near, "look_at");
    }
    script_unknown(L, desc->name, name, near.best);
}

/* Find the transform's rotation for a name that is none of its fields. */
static bool resolve_pose(const char *name, script_access *access)
{
    const kd_field *rotation = script_find_field(access->desc, "rotation");
    const kd_field *place = script_find_field(access->desc, "position");
    bool looks = strcmp(name, "look_at") == 0;
    if (!is_pose(access->desc) || !rotation || !place || (!looks && strcmp(name, "rotation_deg") != 0))
        return false;
    access->kind = looks ? SCRIPT_LOOK_AT : SCRIPT_ROTATION_DEG;
    access->field = *rotation;
    access->position_offset = place->offset;
    return true;
}

/* One number of a vector, or one element of an array, as a field of its own. */
static bool resolve_part(const char *name, script_access *access)
{
    kd_field_ref ref;
    if (!strpbrk(name, ".[") || !kd_desc_field_find(access->desc, name, &ref) || ref.elements != 1 ||
        ref.field->type == KD_QUAT || ref.field->type == KD_STRING)
        return false;
    access->field = *ref.field;
    access->field.type = ref.type;
    access->field.offset = ref.offset;
    access->field.size = ref.field->size / (ref.field->count > 1 ? ref.field->count : 1);
    access->field.count = 1;
    if (ref.part)
        access->field.size = (uint32_t)sizeof(float);
    access->owner = ref.field->name;
    return true;
}

static void resolve(lua_State *L, const char *name, script_access *access)
{
    const kd_field *field = script_find_field(access->desc, name);
    const kd_field *degrees = field ? NULL : find_degrees(access->desc, name);
    const kd_script_host *host = &script_of(L)->host;
    if (field || degrees) {
        access->field = field ? *field : *degrees;
        access->owner = access->field.name;
    } else if (resolve_pose(name, access)) {
        access->owner = "rotation";
    } else if (!resolve_part(name, access)) {
        unknown_field(L, access->desc, name);
    }
    if (degrees) {
        access->kind = SCRIPT_DEGREES;
        access->field.min *= DEG_PER_RAD;
        access->field.max *= DEG_PER_RAD;
    }
    access->writable = !host->may_write || host->may_write(host->user, access->desc->name, access->owner);
}

/* Push the table of the accesses of a component. */
static void push_accesses(lua_State *L, const kd_component_desc *desc)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &access_key);
    if (lua_rawgetp(L, -1, desc) == LUA_TNIL) {
        lua_pop(L, 1);
        lua_newtable(L);
        lua_pushvalue(L, -1);
        lua_rawsetp(L, -3, desc);
    }
    lua_remove(L, -2);
}

const script_access *script_access_at(lua_State *L, const kd_component_desc *desc, int index)
{
    int top = lua_gettop(L);
    const char *name = luaL_checkstring(L, index);
    script_known *known = script_known_at(L, desc, name);
    if (known->owner == desc && known->name == name)
        return known->meaning;
    luaL_checkstack(L, 6, "a field");
    lua_pushvalue(L, index);
    push_accesses(L, desc);
    lua_pushvalue(L, -2);
    if (lua_rawget(L, -2) == LUA_TNIL) {
        script_access found = {.desc = desc, .name = name};
        resolve(L, name, &found);
        lua_pushvalue(L, top + 1); /* the name, kept as key, is what .name points to */
        script_access *access = lua_newuserdatauv(L, sizeof *access, 0);
        *access = found;
        lua_pushvalue(L, -1);
        lua_replace(L, top + 3);
        lua_rawset(L, top + 2);
    }
    const script_access *access = lua_touserdata(L, top + 3);
    if (access->name == name) /* long names have several copies */
        *known = (script_known){desc, name, access};
    lua_settop(L, top);
    return access;
}

const script_access *script_access_named(lua_State *L, const kd_component_desc *desc, const char *name)
{
    lua_pushstring(L, name);
    const script_access *access = script_access_at(L, desc, lua_gettop(L));
    lua_pop(L, 1);
    return access;
}

const char *script_access_name(lua_State *L, const script_access *access)
{
    return lua_pushfstring(L, "%s.%s", access->desc->name, access->name);
}

void script_access_open(lua_State *L)
{
    lua_newtable(L);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &access_key);
}
