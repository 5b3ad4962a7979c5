#ifndef KD_PROFILE_PROTO_H
#define KD_PROFILE_PROTO_H

/* Protocol buffers, the few shapes that a trace needs.
 *
 *  Source  Protocol Buffers encoding: base-128 varints, tags of (field << 3 | wire type), messages by length
 */

#include <stdint.h>
#include <string.h>

/* A message being written; one that does not fit is marked, and must not be used. */
typedef struct proto_message {
    uint8_t bytes[512];
    uint32_t size;
    int overflow;
} proto_message;

static inline void proto_byte(proto_message *m, uint8_t byte)
{
    if (m->size < sizeof m->bytes)
        m->bytes[m->size++] = byte;
    else
        m->overflow = 1;
}

static inline void proto_raw_varint(proto_message *m, uint64_t value)
{
    for (; value >= 0x80; value >>= 7)
        proto_byte(m, (uint8_t)(value | 0x80));
    proto_byte(m, (uint8_t)value);
}

static inline void proto_varint(proto_message *m, uint32_t field, uint64_t value)
{
    proto_raw_varint(m, (uint64_t)field << 3);
    proto_raw_varint(m, value);
}

static inline void proto_double(proto_message *m, uint32_t field, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    proto_raw_varint(m, (uint64_t)field << 3 | 1);
    for (int i = 0; i < 8; i++)
        proto_byte(m, (uint8_t)(bits >> 8 * i));
}

static inline void proto_bytes(proto_message *m, uint32_t field, const void *data, size_t size)
{
    proto_raw_varint(m, (uint64_t)field << 3 | 2);
    proto_raw_varint(m, size);
    for (size_t i = 0; i < size; i++)
        proto_byte(m, ((const uint8_t *)data)[i]);
}

/* Text longer than fits beside the rest is cut. */
static inline void proto_text(proto_message *m, uint32_t field, const char *text)
{
    size_t size = strlen(text);
    proto_bytes(m, field, text, size < 200 ? size : 200);
}

static inline void proto_child(proto_message *m, uint32_t field, const proto_message *child)
{
    m->overflow |= child->overflow;
    proto_bytes(m, field, child->bytes, child->size);
}

#endif
