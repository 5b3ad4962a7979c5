/* Component values to and from Lua, by the field tables alone. */
#include "runtime/script/internal.h"

#include <math.h>
#include <string.h>

#include "runtime/ecs/reflect.h"

#define RAD_PER_DEG     0.017453292519943295
#define MAX_FIELD_BYTES 1024

static uint32_t float_count(kd_field_type type)
{
    switch (type) {
    case KD_F32: return 1;
    case KD_VEC2: return 2;
    case KD_VEC3:
    case KD_COLOR: return 3;
    case KD_VEC4:
    case KD_QUAT: return 4;
    case KD_MAT4: return 16;
    default: return 0;
    }
}

static uint32_t element_count(const kd_field *field)
{
    return field->count > 1 ? field->count : 1;
}

/* ---- to Lua ---- */

static void push_floats(lua_State *L, const float *values, uint32_t count)
{
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_pushnumber(L, (lua_Number)values[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

static void push_enum(lua_State *L, const kd_field *field, uint32_t value)
{
    for (uint32_t i = 0; field->enum_names && field->enum_names[i]; i++) {
        if (i == value) {
            lua_pushstring(L, field->enum_names[i]);
            return;
        }
    }
    lua_pushinteger(L, (lua_Integer)value);
}

static void push_element(lua_State *L, const kd_field *field, const void *at)
{
    float floats[16];
    int32_t i32;
    uint32_t u32, count = float_count(field->type);
    kd_entity entity;
    if (count > 0) {
        memcpy(floats, at, count * sizeof *floats);
        if (count == 1)
            lua_pushnumber(L, (lua_Number)floats[0]);
        else
            push_floats(L, floats, count);
        return;
    }
    switch (field->type) {
    case KD_BOOL: lua_pushboolean(L, *(const uint8_t *)at != 0); return;
    case KD_I32:
        memcpy(&i32, at, sizeof i32);
        lua_pushinteger(L, (lua_Integer)i32);
        return;
    case KD_U32:
        memcpy(&u32, at, sizeof u32);
        lua_pushinteger(L, (lua_Integer)u32);
        return;
    case KD_ENUM:
        memcpy(&u32, at, sizeof u32);
        push_enum(L, field, u32);
        return;
    case KD_ENTITY:
        memcpy(&entity, at, sizeof entity);
        script_push_entity(L, entity);
        return;
    case KD_STRING: lua_pushstring(L, at); return;
    default: lua_pushnil(L); return;
    }
}

void script_push_field(lua_State *L, const script_access *access, const void *component)
{
    const kd_field *field = &access->field;
    const char *at = (const char *)component + field->offset;
    if (access->kind == SCRIPT_LOOK_AT)
        luaL_error(L, "look_at can be set only; read %s.rotation_deg", access->desc->name);
    if (access->kind == SCRIPT_DEGREES) {
        float radians;
        memcpy(&radians, at, sizeof radians);
        lua_pushnumber(L, (lua_Number)radians / RAD_PER_DEG);
        return;
    }
    if (access->kind == SCRIPT_ROTATION_DEG) {
        kd_quat q;
        memcpy(&q, at, sizeof q);
        kd_vec3 deg = script_rotation_to_deg(q);
        push_floats(L, (const float[]){deg.x, deg.y, deg.z}, 3);
        return;
    }
    if (element_count(field) == 1) {
        push_element(L, field, at);
        return;
    }
    uint32_t stride = field->size / field->count;
    lua_createtable(L, (int)field->count, 0);
    for (uint32_t i = 0; i < field->count; i++) {
        push_element(L, field, at + i * stride);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

/* ---- from Lua: `what` is worked out only for a message ---- */

/* Read as many numbers as the list must have; false, having raised nothing, when something is wrong with it.
 */
static bool take_floats(lua_State *L, int index, const kd_field *field, float *out, uint32_t count)
{
    if (!lua_istable(L, index) || lua_rawlen(L, index) != count)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        bool is_number = lua_rawgeti(L, index, (lua_Integer)i + 1) == LUA_TNUMBER;
        out[i] = is_number ? (float)lua_tonumber(L, -1) : NAN;
        lua_pop(L, 1);
        if (!isfinite(out[i]) ||
            (field->min != field->max && !((double)out[i] >= field->min && (double)out[i] <= field->max)))
            return false;
    }
    return true;
}

static void read_floats(lua_State *L, int index, const script_access *access, float *out, uint32_t count)
{
    const kd_field *field = &access->field;
    if (take_floats(L, index, field, out, count))
        return;
    const char *what = script_access_name(L, access);
    script_read_floats(L, index, what, out, count);
    for (uint32_t i = 0; i < count; i++)
        script_check_range(L, what, (double)out[i], field->min, field->max);
    lua_pop(L, 1);
}

static double read_number(lua_State *L, int index, const script_access *access)
{
    const kd_field *field = &access->field;
    double value = lua_type(L, index) == LUA_TNUMBER ? lua_tonumber(L, index) : NAN;
    if (isfinite((float)value) && (field->min == field->max || (value >= field->min && value <= field->max)))
        return value;
    const char *what = script_access_name(L, access);
    if (lua_type(L, index) != LUA_TNUMBER)
        luaL_error(L, "%s must be a number, not a %s; correct it", what, luaL_typename(L, index));
    script_check_range(L, what, value, field->min, field->max);
    return value;
}

static void read_integer(lua_State *L, int index, const script_access *access, void *at)
{
    double value = read_number(L, index, access);
    bool is_signed = access->field.type == KD_I32;
    if (value != floor(value) || value < (is_signed ? (double)INT32_MIN : 0.0) ||
        value > (is_signed ? (double)INT32_MAX : (double)UINT32_MAX))
        luaL_error(L, "%s is %f; it must be a whole number that fits", script_access_name(L, access), value);
    int32_t i32 = is_signed ? (int32_t)value : 0;
    uint32_t u32 = is_signed ? 0 : (uint32_t)value;
    memcpy(at, is_signed ? (const void *)&i32 : (const void *)&u32, sizeof u32);
}

static void read_enum(lua_State *L, int index, const script_access *access, void *at)
{
    const kd_field *field = &access->field;
    luaL_Buffer words;
    if (lua_type(L, index) != LUA_TSTRING)
        luaL_error(L, "%s must be a word in quotes, not a %s; correct it", script_access_name(L, access),
                   luaL_typename(L, index));
    const char *word = lua_tostring(L, index);
    int found = kd_field_enum_find(field, word);
    if (found >= 0) {
        memcpy(at, &(uint32_t){(uint32_t)found}, sizeof(uint32_t));
        return;
    }
    luaL_buffinit(L, &words);
    for (uint32_t i = 0; field->enum_names && field->enum_names[i]; i++) {
        luaL_addstring(&words, i ? ", " : "");
        luaL_addstring(&words, field->enum_names[i]);
    }
    luaL_pushresult(&words);
    const char *choices = lua_tostring(L, -1);
    luaL_error(L, "%s cannot be '%s'; choose one of: %s", script_access_name(L, access), word, choices);
}

static void read_quaternion(lua_State *L, int index, const script_access *access, float *q)
{
    read_floats(L, index, access, q, 4);
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6f && isfinite(length)))
        luaL_error(L, "%s is no rotation: its length is zero; write {0, 0, 0, 1} for none",
                   script_access_name(L, access));
    for (int i = 0; i < 4; i++)
        q[i] /= length;
}

static void read_string(lua_State *L, int index, const script_access *access, char *at)
{
    size_t size;
    const char *text = lua_type(L, index) == LUA_TSTRING ? lua_tolstring(L, index, &size) : NULL;
    if (!text)
        luaL_error(L, "%s must be a string, not a %s; correct it", script_access_name(L, access),
                   luaL_typename(L, index));
    else if (size >= access->field.size || strlen(text) != size)
        luaL_error(L, "%s must have fewer than %d characters; shorten it", script_access_name(L, access),
                   (int)access->field.size);
    else
        memcpy(at, text, size + 1);
}

static void read_entity(lua_State *L, int index, void *at)
{
    kd_entity entity = lua_isnil(L, index) ? KD_NO_ENTITY : script_check_entity(L, index);
    memcpy(at, &entity, sizeof entity);
}

static void read_element(lua_State *L, int index, const script_access *access, void *at)
{
    float floats[16] = {0};
    uint32_t count = float_count(access->field.type);
    switch (access->field.type) {
    case KD_BOOL:
        if (!lua_isboolean(L, index))
            luaL_error(L, "%s must be true or false, not a %s; correct it", script_access_name(L, access),
                       luaL_typename(L, index));
        *(uint8_t *)at = lua_toboolean(L, index) ? 1 : 0;
        return;
    case KD_I32:
    case KD_U32: read_integer(L, index, access, at); return;
    case KD_ENUM: read_enum(L, index, access, at); return;
    case KD_STRING: read_string(L, index, access, at); return;
    case KD_ENTITY: read_entity(L, index, at); return;
    case KD_QUAT: read_quaternion(L, index, access, floats); break;
    case KD_F32: floats[0] = (float)read_number(L, index, access); break;
    default: read_floats(L, index, access, floats, count); break;
    }
    memcpy(at, floats, count * sizeof *floats);
}

static void read_array(lua_State *L, int index, const script_access *access, char *at)
{
    const kd_field *field = &access->field;
    if (!lua_istable(L, index) || lua_rawlen(L, index) > field->count)
        luaL_error(L, "%s must be a list of at most %d entries; correct it", script_access_name(L, access),
                   (int)field->count);
    uint32_t stride = field->size / field->count, count = (uint32_t)lua_rawlen(L, index);
    for (uint32_t i = 0; i < count; i++) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        read_element(L, lua_gettop(L), access, at + i * stride);
        lua_pop(L, 1);
    }
}

/* Read the point that the entity is to look at, below the same parent as it. Returns false when there is
 * none.
 */
static bool read_target(lua_State *L, int index, kd_entity e, kd_vec3 *out)
{
    kd_world *w = script_of(L)->world;
    kd_entity target = script_check_entity(L, index);
    lua_pushliteral(L, "transform");
    script_check_component(L, target, lua_gettop(L));
    lua_pop(L, 1);
    return script_place_below(w, target, kd_get_parent(w, e), out);
}

/* What a transform understands beside its fields. */
static void read_pose(lua_State *L, int index, kd_entity e, const script_access *access,
                      const char *component, char *at)
{
    kd_vec3 v = {0}, position;
    bool looks = access->kind == SCRIPT_LOOK_AT;
    script_access unbounded = *access;
    unbounded.field.min = unbounded.field.max = 0;
    if (!looks || !script_is_entity(L, index))
        read_floats(L, index, &unbounded, &v.x, 3);
    else if (!read_target(L, index, e, &v))
        return; /* no direction leads there: it stays turned as it is */
    memcpy(&position, component + access->position_offset, sizeof position);
    kd_quat q = looks ? script_look_at(position, v) : script_rotation_from_deg(v);
    memcpy(at, &q, sizeof q);
}

void script_read_field(lua_State *L, int index, kd_entity e, const script_access *access, void *component)
{
    const kd_field *field = &access->field;
    char value[MAX_FIELD_BYTES]; /* read aside, so that a value that is refused leaves nothing half written */
    char *to = (char *)component + field->offset;
    index = lua_absindex(L, index);
    luaL_checkstack(L, 8, "a nested value");
    if (!access->writable)
        luaL_error(L, "%s is the runtime's own and cannot be set; read it only",
                   script_access_name(L, access));
    if (field->size > sizeof value)
        luaL_error(L, "%s is too large to be set by a scenario", script_access_name(L, access));
    memcpy(value, to, field->size);
    if (access->kind == SCRIPT_DEGREES) {
        float radians = (float)(read_number(L, index, access) * RAD_PER_DEG);
        memcpy(value, &radians, sizeof radians);
    } else if (access->kind != SCRIPT_PLAIN) {
        read_pose(L, index, e, access, component, value);
    } else if (element_count(field) > 1) {
        read_array(L, index, access, value);
    } else {
        read_element(L, index, access, value);
    }
    memcpy(to, value, field->size);
}

/* Set what the table at `index` names, but for look_at, or that alone. Tells whether something was left out.
 */
static bool read_entries(lua_State *L, int index, kd_entity e, const kd_component_desc *desc, void *value,
                         bool looks)
{
    bool left_out = false;
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            luaL_error(L, "%s: entries without a name are not allowed here; write key = value", desc->name);
        const script_access *access = script_access_at(L, desc, lua_gettop(L) - 1);
        if ((access->kind == SCRIPT_LOOK_AT) == looks)
            script_read_field(L, -1, e, access, value);
        else
            left_out = true;
    }
    return left_out;
}

/* look_at needs the position, whatever order the table has: it is read in a second turn. */
void script_read_component(lua_State *L, int index, kd_entity e, const kd_component_desc *desc, void *value)
{
    index = lua_absindex(L, index);
    if (!lua_istable(L, index))
        luaL_error(L, "%s must be a table of its fields, not a %s; write %s = { … }", desc->name,
                   luaL_typename(L, index), desc->name);
    if (read_entries(L, index, e, desc, value, false))
        read_entries(L, index, e, desc, value, true);
}
