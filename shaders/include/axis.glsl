#ifndef KD_INCLUDE_AXIS_GLSL
#define KD_INCLUDE_AXIS_GLSL

// Axis of a normal, which the opposite normal has too: turned so that its largest part is positive.
ivec3 normal_axis(ivec3 n)
{
    ivec3 a = abs(n);
    int largest = a.x >= a.y && a.x >= a.z ? n.x : a.y >= a.z ? n.y : n.z;
    return largest < 0 ? -n : n;
}

#endif
