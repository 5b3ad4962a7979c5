// What the passes of the octree keep of nodes and of work to do; layout: kd_svo_places in shaders/shared/voxel.h.
// Lists of work are filled in any order: what is done with an entry depends on the entry alone.

#include "shaders/shared/bindings.h"
#include "shaders/shared/voxel.h"

layout(std140, binding = KD_BIND_SVO) uniform places_block { kd_svo_places places; };
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 7) buffer book_block { uint book[]; };

// Enters n into a list unless it is there already.
void book_enter(uint bits, uint list, uint counter, uint n)
{
    uint word = bits + (n >> 5), bit = 1u << (n & 31u);
    if ((book[word] & bit) != 0u || (atomicOr(book[word], bit) & bit) != 0u)
        return;
    book[list + atomicAdd(counters[counter], 1u)] = n;
}

void book_set(uint bits, uint n)
{
    uint word = bits + (n >> 5), bit = 1u << (n & 31u);
    if ((book[word] & bit) == 0u)
        atomicOr(book[word], bit);
}

// A dense cell is to be filtered. Of these, and of nodes, lists are made when all are known: svo/dense_list.comp, node_list.comp.
void book_change_dense(uint code)
{
    book_set(places.changed.x, code);
}

// Leaves came or went in a dense cell.
void book_tell_change(uint code)
{
    book_set(places.news.x, code);
}

// A node of a sparse level (1 …) is to be filtered.
void book_change_node(uint level, uint number)
{
    book_set(places.changed[level], number);
}

// A cell of cascade c that the finer one fills is to be filtered; c may be the number of cascades: what is above the outermost.
void book_change_up(uint c, uint local_code)
{
    if (c < places.size.w)
        book_enter(places.others.y + c * KD_DENSE_WORDS, places.others.z + c * KD_UP_CELLS, KD_COUNT_UP + c, local_code);
    else if (counters[KD_COUNT_UP + c] == 0u)
        counters[KD_COUNT_UP + c] = 1u;
}
