#include "components/bounce.h"

KD_COMPONENT_DEFINE_FLAGS(
    kd_bounce, "bounce", KD_COMPONENT_TRANSIENT,
    KD_FIELD(kd_bounce, frame, KD_U32, NULL, "frames whose light it has seen"),
    KD_FIELD(kd_bounce, period, KD_U32, "frames", "frames in which every cell has its turn"),
    KD_FIELD(kd_bounce, feeds, KD_BOOL, NULL, "light of the frames before is sent out again"),
    KD_FIELD(kd_bounce, again, KD_BOOL, NULL, "light enters the tree twice in this frame"));
