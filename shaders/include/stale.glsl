// What is stale of the static layer; layout: kd_stale_places in shaders/shared/voxel.h. Needs the buffer `stale` and its places
// `stale_at`.

bool stale_brick(uint brick)
{
    return (stale[stale_at.bits + (brick >> 5)] >> (brick & 31u) & 1u) != 0u;
}

// Place of a leaf cell in the compact mask of cells that are built anew: word << 5 | bit. Its brick must be stale.
uint stale_place(uint bit)
{
    return stale[stale_at.slots + (bit >> 8)] << 8 | (bit & 255u);
}
