// What follows when a dense cell has been filtered: is there something in it, and who is made of it.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/atlas.glsl"

void note_filled(uint code, bool filled)
{
    uint word = places.others.x + (code >> 5), bit = 1u << (code & 31u);
    if (filled)
        atomicOr(book[word], bit);
    else
        atomicAnd(book[word], ~bit);
}

// The cell of the next coarser cascade in which a (wrapped) cell of cascade c lies, or all that is above the outermost.
void change_coarser(uint c, ivec3 cell)
{
    uint next = c + 1u, code = 0u;
    if (next < places.size.w) {
        ivec3 from_corner = dense_unwrap(c, uvec3(cell));
        code = morton_encode(dense_wrap(next, (from_corner >> 1) + KD_DENSE / 4));
    }
    book_change_up(next, code);
}
