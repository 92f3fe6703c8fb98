/* PNG without compression: the deflate stream consists of stored blocks. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"

/* Longest stored block. */
#define BLOCK 65535u

static uint8_t *put_u32(uint8_t *to, uint32_t value)
{
    int i;
    for (i = 0; i < 4; i++)
        *to++ = (uint8_t)(value >> (24 - 8 * i));
    return to;
}

static uint32_t crc32(const uint8_t *data, size_t bytes)
{
    uint32_t crc = 0xffffffffu;
    size_t i;
    int bit;
    for (i = 0; i < bytes; i++) {
        crc ^= data[i];
        for (bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static uint32_t adler32(const uint8_t *data, size_t bytes)
{
    uint32_t a = 1, b = 0;
    size_t i;
    for (i = 0; i < bytes; i++) {
        a = (a + data[i]) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

/* A chunk is its length, type and data, and the checksum of the latter two. */
static void write_chunk(FILE *file, const char *type, const uint8_t *data, size_t bytes)
{
    uint8_t *chunk = malloc(bytes + 12);
    if (!chunk)
        die("no memory for a PNG chunk");
    put_u32(chunk, (uint32_t)bytes);
    memcpy(chunk + 4, type, 4);
    if (bytes)
        memcpy(chunk + 8, data, bytes);
    put_u32(chunk + 8 + bytes, crc32(chunk + 4, bytes + 4));
    fwrite(chunk, 1, bytes + 12, file);
    free(chunk);
}

/* Lines of a PNG begin with their filter, which is none. */
static uint8_t *lines_of(const uint8_t *pixels, uint32_t width, uint32_t height, size_t *bytes)
{
    uint8_t *lines, *to;
    uint32_t x, y;
    *bytes = (size_t)height * (1 + (size_t)width * 3);
    lines = to = malloc(*bytes);
    if (!lines)
        die("no memory for a picture");
    for (y = 0; y < height; y++) {
        *to++ = 0;
        for (x = 0; x < width; x++, pixels += 4, to += 3)
            memcpy(to, pixels, 3);
    }
    return lines;
}

/* Wraps data as a zlib stream: a header, stored blocks, a checksum. */
static uint8_t *deflate_stored(const uint8_t *data, size_t bytes, size_t *out_bytes)
{
    size_t blocks = (bytes + BLOCK - 1) / BLOCK, at, length;
    uint8_t *stream = malloc(bytes + blocks * 5 + 6), *to = stream;
    if (!stream)
        die("no memory for a picture");
    *to++ = 0x78;
    *to++ = 0x01;
    for (at = 0; at < bytes; at += length) {
        length = bytes - at < BLOCK ? bytes - at : BLOCK;
        *to++ = at + length == bytes; /* the last one says so */
        *to++ = (uint8_t)length;
        *to++ = (uint8_t)(length >> 8);
        *to++ = (uint8_t)~length;
        *to++ = (uint8_t)(~length >> 8);
        memcpy(to, data + at, length);
        to += length;
    }
    to = put_u32(to, adler32(data, bytes));
    *out_bytes = (size_t)(to - stream);
    return stream;
}

void png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    uint8_t header[13] = {0};
    size_t lines_bytes, stream_bytes;
    uint8_t *lines = lines_of(pixels, width, height, &lines_bytes);
    uint8_t *stream = deflate_stored(lines, lines_bytes, &stream_bytes);
    FILE *file = fopen(path, "wb");
    int failed;
    if (!file)
        die("cannot create %s", path);
    put_u32(header, width);
    put_u32(header + 4, height);
    header[8] = 8; /* bits */
    header[9] = 2; /* red, green, blue */
    fwrite(signature, 1, sizeof signature, file);
    write_chunk(file, "IHDR", header, sizeof header);
    write_chunk(file, "IDAT", stream, stream_bytes);
    write_chunk(file, "IEND", NULL, 0);
    failed = ferror(file);
    if (fclose(file) || failed)
        die("cannot write %s", path);
    free(stream);
    free(lines);
}
