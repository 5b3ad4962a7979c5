// The public headers and macros from C++: a world with a component of this file.
#include "kandil.h"

struct health {
    float left;
    uint32_t armour;
};
KD_COMPONENT_DEFINE(health, "health", KD_FIELD_RANGE(health, left, KD_F32, nullptr, 0, 100, "what is left"),
                    KD_FIELD(health, armour, KD_U32, nullptr, "plates"));
KD_TAG_DEFINE(asleep, "asleep");

int main()
{
    kd_world *w = kd_world_make();
    kd_entity parent = kd_spawn(w, KD_VAL(health, {50, 2}), KD_TAG(asleep));
    kd_entity child = kd_spawn_child(w, parent, KD_VAL(health, {25, 1}));
    kd_set(w, child, health, {75, 3});
    kd_query_desc desc{};
    desc.terms[0] = KD_WRITE(health);
    kd_query *q = kd_query_make(w, &desc);
    float sum = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++)
            sum += KD_COLUMN_MUT(&it, health, 0)[i].left;
    const health *h = kd_find(w, child, health);
    bool good = sum == 125 && h && h->armour == 3 && kd_has(w, parent, asleep) && !kd_has(w, child, asleep);
    kd_world_destroy(w);
    return good ? 0 : 1;
}
