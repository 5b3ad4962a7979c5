/* Room for nodes: what is known of those that there are moves along into larger tables. */
#include <stdlib.h>
#include <string.h>

#include "systems/svo/internal.h"

/* A table of rows of `stride` bytes for the nodes of levels `first` … end - 1, with the rows of the old one.
 */
static kd_gpu_buffer grown(kd_gpu *gpu, const kd_svo *svo, kd_gpu_buffer old, const uint32_t *room,
                           uint32_t first, uint32_t end, size_t stride, const char *name)
{
    kd_gpu_buffer made = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = svo_rows(room, first, end) * stride, .name = name});
    size_t from = 0, to = 0;
    for (uint32_t l = first; l < end && made.id; l++) {
        if (old.id && svo->node_room[l])
            kd_gpu_copy_buffer(gpu, old, from, made, to, svo->node_room[l] * stride);
        from += svo->node_room[l] * stride;
        to += room[l] * stride;
    }
    return made;
}

size_t svo_node_bytes(const kd_svo *svo, const uint32_t *room)
{
    uint32_t top = svo_levels(svo) - 1;
    size_t dense = (size_t)svo->cascades * KD_DENSE * KD_DENSE * KD_DENSE;
    return top == 0 ? dense * 4 : (svo_rows(room, 0, top) + room[top - 1]) * 32;
}

double svo_table_share(const kd_svo *svo, const double nodes[KD_MAX_NODE_LEVELS], uint64_t bytes)
{
    uint32_t top = svo_levels(svo) - 1;
    uint64_t fixed = svo_fixed_book_bytes(svo), left = fixed < bytes / 2 ? bytes - fixed : bytes / 2;
    double words = 0, book = 4 * (nodes[top] + 32);
    for (uint32_t l = 0; l <= top; l++) {
        double room = nodes[l] + 32;      /* it is rounded up to that */
        words += l < top ? 32 * room : 0; /* of children, and to leaves of these */
        words += l + 1 == top ? 32 * room : 0;
        book += 8.125 * room; /* code, place in the stack of numbers, a bit */
    }
    words /= (double)bytes;
    book /= (double)left;
    return words > book ? words : book;
}

void svo_fit_tables(const kd_svo *svo, const double *least, const double *want, uint32_t *room)
{
    double few = svo_table_share(svo, least, svo->most_bytes),
           many = svo_table_share(svo, want, svo->most_bytes), more = many > 1 ? (1 - few) / (many - few) : 1;
    for (uint32_t l = 0; l < svo_levels(svo); l++)
        room[l] = (uint32_t)(few < 1 ? least[l] + more * (want[l] - least[l]) : least[l] / few);
}

/* Words that lead to nodes, and behind them those that lead to leaves, one beside each of the last level's.
 */
static kd_gpu_buffer grown_nodes(kd_gpu *gpu, const kd_svo *svo, const uint32_t *room)
{
    uint32_t top = svo_levels(svo) - 1;
    kd_gpu_buffer made = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = svo_node_bytes(svo, room), .zeroed = true, .name = "tree.nodes"});
    size_t from = 0, to = 0, last = 0;
    if (!svo->nodes.id || !made.id)
        return made;
    for (uint32_t l = 0; l < top; from += last, to += room[l] * 32ul, l++) {
        last = svo->node_room[l] * 32ul;
        kd_gpu_copy_buffer(gpu, svo->nodes, from, made, to, last);
    }
    kd_gpu_copy_buffer(gpu, svo->nodes, from, made, to, top == 0 ? svo_node_bytes(svo, room) : last);
    return made;
}

/* Free numbers of a level: the new ones lie below those that were free, so that low numbers go first. */
static kd_status grow_stack(kd_gpu *gpu, const kd_svo *svo, const struct kd_svo_places *p, kd_gpu_buffer book,
                            uint32_t l)
{
    uint32_t room = (&p->room.x)[l], more = room - svo->node_room[l], was = 0;
    size_t counter = (size_t)(KD_COUNT_FREE + l) * 4;
    uint32_t *stack = malloc((size_t)room * sizeof *stack);
    if (!stack)
        return KD_NO_MEMORY;
    kd_gpu_read_buffer(gpu, svo->counters, counter, &was, sizeof was);
    for (uint32_t i = 0; i < more; i++)
        stack[i] = room - 1 - i;
    if (was)
        kd_gpu_read_buffer(gpu, svo->book, (size_t)(&svo->places.free.x)[l] * 4, stack + more,
                           (size_t)was * sizeof *stack);
    was += more;
    if (was)
        kd_gpu_write_buffer(gpu, book, (size_t)(&p->free.x)[l] * 4, stack, (size_t)was * sizeof *stack);
    kd_gpu_write_buffer(gpu, svo->counters, counter, &was, sizeof was);
    free(stack);
    return KD_OK;
}

static kd_status grow_book(kd_gpu *gpu, const kd_svo *svo, const struct kd_svo_places *p, kd_gpu_buffer book)
{
    size_t fixed = svo_fixed_book_bytes(svo);
    kd_status status = KD_OK;
    kd_gpu_fill_buffer(gpu, book, 0, kd_gpu_buffer_size(gpu, book), 0);
    if (svo->node_capacity) { /* what is fixed, then words of static blocks */
        kd_gpu_copy_buffer(gpu, svo->book, 0, book, 0, fixed);
        kd_gpu_copy_buffer(gpu, svo->book, fixed, book, fixed, (size_t)svo->node_capacity * 4);
    }
    for (uint32_t l = 0; l < svo_levels(svo) && !status; l++) {
        size_t at = (size_t)(&p->codes.x)[l] * 4, old = (size_t)svo->node_room[l] * 4;
        kd_gpu_fill_buffer(gpu, book, at, (size_t)(&p->room.x)[l] * 4, KD_EMPTY);
        if (old)
            kd_gpu_copy_buffer(gpu, svo->book, (size_t)(&svo->places.codes.x)[l] * 4, book, at, old);
        status = grow_stack(gpu, svo, p, book, l);
    }
    return status;
}

kd_status svo_reserve_nodes(kd_gpu *gpu, kd_svo *svo, const uint32_t *wanted)
{
    uint32_t levels = svo_levels(svo), top = levels - 1, room[KD_MAX_NODE_LEVELS];
    bool more = false;
    for (uint32_t l = 0; l < levels; l++) {
        uint32_t want = (wanted[l] + 31) / 32 * 32;
        room[l] = want > svo->node_room[l] ? want : svo->node_room[l];
        if (l > 0 && room[l] < room[l - 1]) /* no level has fewer nodes than the one above */
            room[l] = room[l - 1];
        more = more || room[l] > svo->node_room[l];
    }
    if (!more)
        return KD_OK;
    struct kd_svo_places places = svo->places;
    size_t book_bytes = (size_t)svo_place_nodes(svo, &places, room) * 4;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_buffer *held[] = {&svo->nodes, &svo->data, &svo->book};
    kd_gpu_buffer made[] = {
        grown_nodes(gpu, svo, room),
        grown(gpu, svo, svo->data, room, 1, levels, 8, "tree.data"),
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = book_bytes, .name = "svo.book"}),
    };
    bool all = true;
    for (size_t i = 0; i < sizeof made / sizeof *made; i++)
        all = all && made[i].id;
    kd_status status = all ? grow_book(gpu, svo, &places, made[2]) : KD_GPU;
    for (size_t i = 0; i < sizeof made / sizeof *made; i++) {
        kd_gpu_destroy_buffer(gpu, status ? made[i] : *held[i]);
        if (!status)
            *held[i] = made[i];
    }
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    if (status)
        return status;
    svo->places = places;
    memcpy(svo->node_room, room, levels * sizeof *room);
    svo->node_capacity = room[top];
    return KD_OK;
}
