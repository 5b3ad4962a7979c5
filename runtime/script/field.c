/* Component values to and from Lua, by the field tables alone. */
#include "runtime/script/internal.h"

#include <math.h>
#include <string.h>

#include "runtime/core/nearest.h"

#define RAD_PER_DEG 0.017453292519943295

static uint32_t float_count(kd_field_type type) {
    switch (type) {
    case KD_F32:
        return 1;
    case KD_VEC2:
        return 2;
    case KD_VEC3:
    case KD_COLOR:
        return 3;
    case KD_VEC4:
    case KD_QUAT:
        return 4;
    case KD_MAT4:
        return 16;
    default:
        return 0;
    }
}

static uint32_t element_count(const kd_field *field) {
    return field->count > 1 ? field->count : 1;
}

const kd_field *script_find_field(const kd_component_desc *desc, const char *name) {
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (strcmp(desc->fields[i].name, name) == 0)
            return &desc->fields[i];
    return NULL;
}

/* "fov_y_deg" finds the field "fov_y" when that is an angle. */
static const kd_field *find_degrees(const kd_component_desc *desc, const char *name) {
    size_t length = strlen(name);
    if (length < 5 || strcmp(name + length - 4, "_deg") != 0)
        return NULL;
    for (uint32_t i = 0; i < desc->field_count; i++) {
        const kd_field *f = &desc->fields[i];
        if (f->type == KD_F32 && f->unit && strcmp(f->unit, "rad") == 0 && strlen(f->name) == length - 4 &&
            strncmp(f->name, name, length - 4) == 0)
            return f;
    }
    return NULL;
}

static bool is_pose(const kd_component_desc *desc) {
    return strcmp(desc->name, "transform") == 0;
}

static _Noreturn void unknown_field(lua_State *L, const kd_component_desc *desc, const char *name) {
    kd_nearest near = kd_nearest_to(name);
    for (uint32_t i = 0; i < desc->field_count; i++) {
        kd_nearest_offer(&near, desc->fields[i].name);
        if (desc->fields[i].unit && strcmp(desc->fields[i].unit, "rad") == 0)
            kd_nearest_offer(&near, lua_pushfstring(L, "%s_deg", desc->fields[i].name));
    }
    if (is_pose(desc)) {
        kd_nearest_offer(&near, "rotation_deg");
        kd_nearest_offer(&near, "look_at");
    }
    script_unknown(L, desc->name, name, near.best);
}

/* ---- to Lua ---- */

static void push_floats(lua_State *L, const float *values, uint32_t count) {
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_pushnumber(L, (lua_Number)values[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

static void push_enum(lua_State *L, const kd_field *field, uint32_t value) {
    for (uint32_t i = 0; field->enum_names && field->enum_names[i]; i++) {
        if (i == value) {
            lua_pushstring(L, field->enum_names[i]);
            return;
        }
    }
    lua_pushinteger(L, (lua_Integer)value);
}

static void push_element(lua_State *L, const kd_field *field, const void *at) {
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
    case KD_BOOL:
        lua_pushboolean(L, *(const uint8_t *)at != 0);
        return;
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
    case KD_STRING:
        lua_pushstring(L, at);
        return;
    default:
        lua_pushnil(L);
        return;
    }
}

void script_push_field(lua_State *L, const kd_component_desc *desc, const char *name, const void *value) {
    const kd_field *field = script_find_field(desc, name), *degrees = field ? NULL : find_degrees(desc, name);
    if (degrees) {
        float radians;
        memcpy(&radians, (const char *)value + degrees->offset, sizeof radians);
        lua_pushnumber(L, (lua_Number)radians / RAD_PER_DEG);
        return;
    }
    if (!field && is_pose(desc) && strcmp(name, "rotation_deg") == 0) {
        kd_quat q;
        memcpy(&q, (const char *)value + script_find_field(desc, "rotation")->offset, sizeof q);
        kd_vec3 deg = script_rotation_to_deg(q);
        push_floats(L, (const float[]){deg.x, deg.y, deg.z}, 3);
        return;
    }
    if (!field)
        unknown_field(L, desc, name);
    const char *at = (const char *)value + field->offset;
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

/* ---- from Lua ---- */

static double read_number(lua_State *L, int index, const char *what, const kd_field *field) {
    if (lua_type(L, index) != LUA_TNUMBER)
        luaL_error(L, "%s must be a number, not a %s; correct it", what, luaL_typename(L, index));
    double value = lua_tonumber(L, index);
    script_check_range(L, what, value, field->min, field->max);
    return value;
}

static void read_integer(lua_State *L, int index, const char *what, const kd_field *field, void *at) {
    double value = read_number(L, index, what, field);
    bool is_signed = field->type == KD_I32;
    if (value != floor(value) || value < (is_signed ? (double)INT32_MIN : 0.0) ||
        value > (is_signed ? (double)INT32_MAX : (double)UINT32_MAX))
        luaL_error(L, "%s is %f; it must be a whole number that fits", what, value);
    int32_t i32 = is_signed ? (int32_t)value : 0;
    uint32_t u32 = is_signed ? 0 : (uint32_t)value;
    memcpy(at, is_signed ? (const void *)&i32 : (const void *)&u32, sizeof u32);
}

static void read_enum(lua_State *L, int index, const char *what, const kd_field *field, void *at) {
    if (lua_type(L, index) != LUA_TSTRING)
        luaL_error(L, "%s must be a word in quotes, not a %s; correct it", what, luaL_typename(L, index));
    const char *word = lua_tostring(L, index);
    luaL_Buffer words;
    for (uint32_t i = 0; field->enum_names && field->enum_names[i]; i++) {
        if (strcmp(field->enum_names[i], word) == 0) {
            memcpy(at, &i, sizeof i);
            return;
        }
    }
    luaL_buffinit(L, &words);
    for (uint32_t i = 0; field->enum_names && field->enum_names[i]; i++) {
        luaL_addstring(&words, i ? ", " : "");
        luaL_addstring(&words, field->enum_names[i]);
    }
    luaL_pushresult(&words);
    luaL_error(L, "%s cannot be '%s'; choose one of: %s", what, word, lua_tostring(L, -1));
}

static void read_quaternion(lua_State *L, int index, const char *what, float *q) {
    script_read_floats(L, index, what, q, 4);
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6f && isfinite(length)))
        luaL_error(L, "%s is no rotation: its length is zero; write {0, 0, 0, 1} for none", what);
    for (int i = 0; i < 4; i++)
        q[i] /= length;
}

static void read_string(lua_State *L, int index, const char *what, const kd_field *field, char *at) {
    size_t size;
    const char *text = lua_type(L, index) == LUA_TSTRING ? lua_tolstring(L, index, &size) : NULL;
    if (!text)
        luaL_error(L, "%s must be a string, not a %s; correct it", what, luaL_typename(L, index));
    else if (size >= field->size || strlen(text) != size)
        luaL_error(L, "%s must have fewer than %d characters; shorten it", what, (int)field->size);
    else
        memcpy(at, text, size + 1);
}

static void read_floats(lua_State *L, int index, const char *what, const kd_field *field, void *at) {
    float floats[16];
    uint32_t count = float_count(field->type);
    if (field->type == KD_QUAT)
        read_quaternion(L, index, what, floats);
    else if (count == 1)
        floats[0] = (float)read_number(L, index, what, field);
    else
        script_read_floats(L, index, what, floats, count);
    for (uint32_t i = 0; i < count && field->type != KD_QUAT; i++)
        script_check_range(L, what, (double)floats[i], field->min, field->max);
    memcpy(at, floats, count * sizeof *floats);
}

static void read_element(lua_State *L, int index, const char *what, const kd_field *field, void *at) {
    switch (field->type) {
    case KD_BOOL:
        if (!lua_isboolean(L, index))
            luaL_error(L, "%s must be true or false, not a %s; correct it", what, luaL_typename(L, index));
        *(uint8_t *)at = lua_toboolean(L, index) ? 1 : 0;
        return;
    case KD_I32:
    case KD_U32:
        read_integer(L, index, what, field, at);
        return;
    case KD_ENUM:
        read_enum(L, index, what, field, at);
        return;
    case KD_STRING:
        read_string(L, index, what, field, at);
        return;
    case KD_ENTITY: {
        kd_entity entity = script_check_entity(L, index);
        memcpy(at, &entity, sizeof entity);
        return;
    }
    default:
        read_floats(L, index, what, field, at);
        return;
    }
}

static void read_array(lua_State *L, int index, const char *what, const kd_field *field, char *at) {
    if (!lua_istable(L, index) || lua_rawlen(L, index) > field->count)
        luaL_error(L, "%s must be a list of at most %d entries; correct it", what, (int)field->count);
    uint32_t stride = field->size / field->count, count = (uint32_t)lua_rawlen(L, index);
    for (uint32_t i = 0; i < count; i++) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        read_element(L, lua_gettop(L), what, field, at + i * stride);
        lua_pop(L, 1);
    }
}

/* What a transform understands beside its fields; false when `name` is none of it. */
static bool read_pose(lua_State *L, int index, const char *what, const kd_component_desc *desc,
                      const char *name, void *value) {
    kd_vec3 v, position;
    bool looks = strcmp(name, "look_at") == 0;
    const kd_field *rotation = script_find_field(desc, "rotation"),
                   *place = script_find_field(desc, "position");
    if (!is_pose(desc) || !rotation || !place || (!looks && strcmp(name, "rotation_deg") != 0))
        return false;
    script_read_floats(L, index, what, &v.x, 3);
    memcpy(&position, (const char *)value + place->offset, sizeof position);
    kd_quat q = looks ? script_look_at(position, v) : script_rotation_from_deg(v);
    memcpy((char *)value + rotation->offset, &q, sizeof q);
    return true;
}

void script_read_field(lua_State *L, int index, const kd_component_desc *desc, const char *name,
                       void *value) {
    int top = lua_gettop(L);
    index = lua_absindex(L, index);
    luaL_checkstack(L, 8, "a nested value");
    const kd_script_host *host = &script_of(L)->host;
    const char *what = lua_pushfstring(L, "%s.%s", desc->name, name);
    const kd_field *field = script_find_field(desc, name), *degrees = field ? NULL : find_degrees(desc, name);
    if ((field || degrees) && host->may_write &&
        !host->may_write(host->user, desc->name, (field ? field : degrees)->name))
        luaL_error(L, "%s is the runtime's own and cannot be set; read it only", what);
    if (degrees) {
        kd_field in_degrees = *degrees;
        in_degrees.min /= RAD_PER_DEG;
        in_degrees.max /= RAD_PER_DEG;
        float radians = (float)(read_number(L, index, what, &in_degrees) * RAD_PER_DEG);
        memcpy((char *)value + degrees->offset, &radians, sizeof radians);
    } else if (!field) {
        if (!read_pose(L, index, what, desc, name, value))
            unknown_field(L, desc, name);
    } else if (element_count(field) > 1) {
        read_array(L, index, what, field, (char *)value + field->offset);
    } else {
        read_element(L, index, what, field, (char *)value + field->offset);
    }
    lua_settop(L, top);
}

void script_read_component(lua_State *L, int index, const kd_component_desc *desc, void *value) {
    index = lua_absindex(L, index);
    if (!lua_istable(L, index))
        luaL_error(L, "%s must be a table of its fields, not a %s; write %s = { … }", desc->name,
                   luaL_typename(L, index), desc->name);
    /* look_at needs the position, whatever order the table has: it is read in a second turn. */
    for (int turn = 0; turn < 2; turn++) {
        for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
            if (lua_type(L, -2) != LUA_TSTRING)
                luaL_error(L, "%s: entries without a name are not allowed here; write key = value",
                           desc->name);
            const char *key = lua_tostring(L, -2);
            if ((strcmp(key, "look_at") == 0) == (turn == 1))
                script_read_field(L, -1, desc, key, value);
        }
    }
}
