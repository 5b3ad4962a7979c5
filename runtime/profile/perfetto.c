/* The timeline as a Perfetto trace: packets of track descriptors, names and track events.
 *
 *  Source  Perfetto's protos/perfetto/trace: trace.proto, trace_packet.proto, track_event/track_event.proto,
 *          track_descriptor.proto, counter_descriptor.proto, interned_data.proto */
#include <assert.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/file.h"
#include "runtime/profile/internal.h"
#include "runtime/profile/proto.h"

/* Field numbers, by message. */
enum { TRACE_PACKET = 1 };
enum {
    PACKET_TIMESTAMP = 8,
    PACKET_SEQUENCE = 10,
    PACKET_EVENT = 11,
    PACKET_INTERNED = 12,
    PACKET_FLAGS = 13,
    PACKET_TRACK = 60
};
enum {
    TRACK_UUID = 1,
    TRACK_NAME = 2,
    TRACK_PROCESS = 3,
    TRACK_THREAD = 4,
    TRACK_PARENT = 5,
    TRACK_COUNTER = 8
};
enum { PROCESS_PID = 1, PROCESS_NAME = 6 };
enum { THREAD_PID = 1, THREAD_TID = 2, THREAD_NAME = 5 };
enum { INTERNED_CATEGORIES = 1, INTERNED_NAMES = 2, INTERNED_IID = 1, INTERNED_TEXT = 2 };
enum { EVENT_CATEGORY_IIDS = 3, EVENT_TYPE = 9, EVENT_NAME_IID = 10, EVENT_TRACK = 11, EVENT_DOUBLE = 44 };
enum { EVENT_BEGIN = 1, EVENT_END = 2, EVENT_COUNTER = 4 };
enum { FLAG_CLEARED = 1, FLAG_NEEDED = 2 };
enum { SEQUENCE = 1, PROCESS_UUID = 1, FIRST_TRACK_UUID = 16, FIRST_COUNTER_UUID = 1024 };

typedef struct writer {
    FILE *out;
    const kd_trace *trace;
} writer;

static void put_packet(writer *w, const proto_message *packet)
{
    proto_message head = {.size = 0};
    proto_raw_varint(&head, TRACE_PACKET << 3 | 2);
    proto_raw_varint(&head, packet->size);
    assert(!packet->overflow);
    fwrite(head.bytes, 1, head.size, w->out); /* the file's end reports what failed */
    fwrite(packet->bytes, 1, packet->size, w->out);
}

static void put_track(writer *w, const proto_message *track)
{
    proto_message packet = {.size = 0};
    proto_varint(&packet, PACKET_SEQUENCE, SEQUENCE);
    proto_child(&packet, PACKET_TRACK, track);
    put_packet(w, &packet);
}

/* ---- what there is ---- */

static void put_process(writer *w)
{
    proto_message process = {.size = 0}, track = {.size = 0};
    proto_varint(&process, PROCESS_PID, (uint64_t)getpid());
    proto_text(&process, PROCESS_NAME, "kandil");
    proto_varint(&track, TRACK_UUID, PROCESS_UUID);
    proto_child(&track, TRACK_PROCESS, &process);
    put_track(w, &track);
}

/* Threads by their number here: it is the same in every run, and the viewer sorts by it. */
static void put_tracks(writer *w)
{
    for (uint32_t i = 0; i < kd_trace_track_count(w->trace); i++) {
        proto_message thread = {.size = 0}, track = {.size = 0};
        kd_trace_kind kind;
        const char *name = kd_trace_track_name(w->trace, i, &kind);
        if (!name)
            continue;
        proto_varint(&track, TRACK_UUID, FIRST_TRACK_UUID + i);
        proto_varint(&track, TRACK_PARENT, PROCESS_UUID);
        if (kind == KD_TRACE_THREAD) {
            proto_varint(&thread, THREAD_PID, (uint64_t)getpid());
            proto_varint(&thread, THREAD_TID, i + 1);
            proto_text(&thread, THREAD_NAME, name);
            proto_child(&track, TRACK_THREAD, &thread);
        } else {
            proto_text(&track, TRACK_NAME, name);
        }
        put_track(w, &track);
    }
}

static void put_counter_track(writer *w, kd_trace_name name)
{
    const char *category;
    proto_message counter = {.size = 0}, track = {.size = 0};
    proto_varint(&track, TRACK_UUID, FIRST_COUNTER_UUID + name);
    proto_varint(&track, TRACK_PARENT, PROCESS_UUID);
    proto_text(&track, TRACK_NAME, kd_trace_name_text(w->trace, name, &category));
    proto_child(&track, TRACK_COUNTER, &counter);
    put_track(w, &track);
}

static void put_interned(writer *w, kd_trace_name name, bool first)
{
    const char *category;
    const char *text = kd_trace_name_text(w->trace, name, &category);
    proto_message entry = {.size = 0}, type = {.size = 0}, interned = {.size = 0}, packet = {.size = 0};
    proto_varint(&entry, INTERNED_IID, name + 1u);
    proto_text(&entry, INTERNED_TEXT, text);
    proto_varint(&type, INTERNED_IID, name + 1u);
    proto_text(&type, INTERNED_TEXT, category);
    proto_child(&interned, INTERNED_CATEGORIES, &type);
    proto_child(&interned, INTERNED_NAMES, &entry);
    proto_varint(&packet, PACKET_SEQUENCE, SEQUENCE);
    proto_varint(&packet, PACKET_FLAGS, first ? FLAG_CLEARED | FLAG_NEEDED : FLAG_NEEDED);
    proto_child(&packet, PACKET_INTERNED, &interned);
    put_packet(w, &packet);
}

/* ---- what happened ---- */

static void put_event(writer *w, uint64_t ns, const proto_message *event)
{
    proto_message packet = {.size = 0};
    proto_varint(&packet, PACKET_TIMESTAMP, ns);
    proto_varint(&packet, PACKET_SEQUENCE, SEQUENCE);
    proto_varint(&packet, PACKET_FLAGS, FLAG_NEEDED);
    proto_child(&packet, PACKET_EVENT, event);
    put_packet(w, &packet);
}

static void put_begin(writer *w, uint32_t track, const kd_trace_event *zone)
{
    proto_message event = {.size = 0};
    proto_varint(&event, EVENT_CATEGORY_IIDS, zone->name + 1u);
    proto_varint(&event, EVENT_TYPE, EVENT_BEGIN);
    proto_varint(&event, EVENT_NAME_IID, zone->name + 1u);
    proto_varint(&event, EVENT_TRACK, FIRST_TRACK_UUID + track);
    put_event(w, zone->start_ns, &event);
}

static void put_end(writer *w, uint32_t track, uint64_t ns)
{
    proto_message event = {.size = 0};
    proto_varint(&event, EVENT_TYPE, EVENT_END);
    proto_varint(&event, EVENT_TRACK, FIRST_TRACK_UUID + track);
    put_event(w, ns, &event);
}

/* Zones are sorted and nested: those that are over are closed, innermost first, before the next one opens. */
static void put_zones(writer *w, uint32_t track)
{
    uint64_t count, ends[KD_TRACE_MAX_DEPTH];
    uint32_t open = 0;
    const kd_trace_event *zones = kd_trace_events(w->trace, track, &count);
    for (uint64_t i = 0; i < count; i++) {
        if (zones[i].depth >= KD_TRACE_MAX_DEPTH)
            continue;
        while (open > zones[i].depth)
            put_end(w, track, ends[--open]);
        put_begin(w, track, &zones[i]);
        ends[open++] = zones[i].end_ns;
    }
    while (open > 0)
        put_end(w, track, ends[--open]);
}

static void put_values(writer *w)
{
    uint64_t count;
    const kd_trace_value *values = kd_trace_values(w->trace, &count);
    for (uint64_t i = 0; i < count; i++) {
        proto_message event = {.size = 0};
        proto_varint(&event, EVENT_TYPE, EVENT_COUNTER);
        proto_varint(&event, EVENT_TRACK, FIRST_COUNTER_UUID + values[i].name);
        proto_double(&event, EVENT_DOUBLE, values[i].value);
        put_event(w, values[i].ns, &event);
    }
}

kd_status profile_write_perfetto(const kd_trace *trace, const char *path)
{
    kd_file_out file;
    kd_status status = kd_file_out_open(&file, path);
    if (status != KD_OK)
        return status;
    writer w = {.out = file.stream, .trace = trace};
    put_process(&w);
    put_tracks(&w);
    for (uint32_t i = 0; i < kd_trace_name_count(trace); i++)
        put_interned(&w, i, i == 0);
    for (uint32_t i = 0; i < kd_trace_name_count(trace); i++)
        if (profile_is_counter(trace, i))
            put_counter_track(&w, i);
    for (uint32_t i = 0; i < kd_trace_track_count(trace); i++)
        put_zones(&w, i);
    put_values(&w);
    return kd_file_out_commit(&file);
}
