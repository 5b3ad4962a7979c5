#include "components/light_jump.h"

KD_COMPONENT_DEFINE_FLAGS(kd_light_jump, "light_jump", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_light_jump, measured, KD_BOOL, NULL,
                                   "light was compared in this frame"));
