#ifndef KD_SHADERS_BRDF_H
#define KD_SHADERS_BRDF_H

/* Constants of the surface model, for shaders and for the reference renderer alike. */
#define KD_BRDF_DIELECTRIC_F0 0.04
/* A mirror under a light without extent has no picture; this much roughness keeps the highlight finite. */
#define KD_BRDF_MIN_ROUGHNESS 0.04

#endif
