/* A component of one's own in snapshots, from outside of the tree: it comes back as it was, in a world of its
 * own too, and what has changed since is named by its field. */
#include <stdio.h>
#include <string.h>

#include "kandil.h"

typedef struct fuel {
    float litres;
    uint32_t tank;
} fuel;
KD_COMPONENT_DEFINE(fuel, "fuel", KD_FIELD_RANGE(fuel, litres, KD_F32, "l", 0, 100, "what is left"),
                    KD_FIELD(fuel, tank, KD_U32, NULL, "number"));

#define EXPECT(condition)                                                                                    \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "line %d: not so: %s\n", __LINE__, #condition);                                  \
            return 1;                                                                                        \
        }                                                                                                    \
    } while (0)

int main(void)
{
    kd_world *w = kd_world_make(), *other = kd_world_make();
    kd_entity car = kd_spawn(w, KD_VAL(fuel, {40, 2}));
    kd_snapshot s = {0};
    kd_difference d[2];
    char text[128];
    EXPECT(kd_snapshot_write(w, &s) == KD_OK);
    (void)KD_ID(other, fuel);
    EXPECT(kd_snapshot_restore(other, s.data, s.size) == KD_OK);
    EXPECT(kd_world_checksum(w) == kd_world_checksum(other));
    kd_set(w, car, fuel, {39, 2});
    EXPECT(kd_world_diff(other, w, d, 2) == 1);
    EXPECT(strstr(kd_difference_text(other, w, &d[0], text, sizeof text), "fuel.litres differs") != NULL);
    EXPECT(kd_snapshot_restore(w, s.data, s.size) == KD_OK);
    EXPECT(kd_find(w, car, fuel)->litres == 40);
    kd_snapshot_fini(&s);
    kd_world_destroy(other);
    kd_world_destroy(w);
    return 0;
}
