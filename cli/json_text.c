#include "json_text.h"

#include <stddef.h>

// Bytes of the character there; 0 when it is no UTF-8 (RFC 3629: neither surrogates nor longer than
// need be).
static size_t character_size(const unsigned char *c)
{
    if (*c < 0x80)
        return 1;
    size_t size = *c >= 0xf5 || *c < 0xc2 ? 0 : *c >= 0xf0 ? 4 : *c >= 0xe0 ? 3 : 2;
    unsigned least = *c == 0xe0 ? 0xa0 : *c == 0xf0 ? 0x90 : 0x80;
    unsigned most = *c == 0xed ? 0x9f : *c == 0xf4 ? 0x8f : 0xbf;
    if (size && (c[1] < least || c[1] > most))
        return 0;
    for (size_t i = 2; i < size; i++)
        if ((c[i] & 0xc0) != 0x80)
            return 0;
    return size;
}

void json_print_text(const char *text, FILE *out)
{
    fputc('"', out);
    for (const unsigned char *c = (const unsigned char *)(text ? text : ""); *c;) {
        size_t size = character_size(c);
        if (*c == '"' || *c == '\\')
            fprintf(out, "\\%c", *c);
        else if (*c < 0x20)
            fprintf(out, "\\u%04x", *c);
        else if (size)
            fwrite(c, 1, size, out);
        else
            fprintf(out, "\\ufffd");
        c += size ? size : 1;
    }
    fputc('"', out);
}
