/* Collects what the program may say when something goes wrong: the formats of all calls that fail or warn,
 * for `kandil help messages`.
 *
 *     messages ROOT FILES...    prints a C array, app_messages, a row a message: the folder and the format
 * with an ellipsis for what is filled in */
#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 4096, LONGEST = 1024 };

static struct row {
    char folder[96], text[LONGEST];
} rows[MOST];
static size_t row_count;

static const char *const calls[] = {"kd_fail",    "gltf_fail", "gltf_warn",    "gpu_fail", "gpu_complain",
                                    "luaL_error", "kd_log",    "svo_say_once", "refuse",   "lua_pushliteral"};

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    long size;
    if (file && fseek(file, 0, SEEK_END) == 0 && (size = ftell(file)) >= 0 && fseek(file, 0, SEEK_SET) == 0 &&
        (text = calloc((size_t)size + 1, 1)) != NULL && fread(text, 1, (size_t)size, file) != (size_t)size)
        text[0] = '\0';
    if (file)
        fclose(file);
    return text;
}

/* Copy a string literal's inside, from after its quote; what printf fills in becomes an ellipsis. Returns
 * what follows the closing quote. */
static const char *copy_literal(const char *p, char *out, size_t *used)
{
    while (*p && *p != '"' && *used + 8 < LONGEST) {
        if (p[0] == '\\' && p[1]) {
            out[(*used)++] = p[1] == 'n' ? ' ' : p[1];
            p += 2;
        } else if (p[0] == '%' && p[1] == '%') {
            out[(*used)++] = '%';
            p += 2;
        } else if (p[0] == '%') {
            p += 1 + strcspn(p + 1, "diouxXeEfgGaAcspI\"");
            p += *p && *p != '"';
            memcpy(out + *used, "…", strlen("…"));
            *used += strlen("…");
        } else {
            out[(*used)++] = *p++;
        }
    }
    return *p ? p + 1 : p;
}

/* The first run of adjacent literals of a call; a macro between them stands for something filled in. Returns
 * false when there is none before the call ends. */
static bool format_of(const char *p, char *out)
{
    size_t used = 0;
    for (int depth = 1; *p && depth > 0 && *p != '"'; p++)
        depth += *p == '(' ? 1 : *p == ')' ? -1 : 0;
    while (*p == '"') {
        p = copy_literal(p + 1, out, &used);
        p += strspn(p, " \n\t");
    }
    out[used] = '\0';
    return used > 0;
}

static void add(const char *folder, size_t folder_length, const char *text)
{
    if (!strchr(text, ' ') || strlen(text) < 12 || row_count == MOST)
        return;
    snprintf(rows[row_count].folder, sizeof rows->folder, "%.*s", (int)folder_length, folder);
    snprintf(rows[row_count++].text, LONGEST, "%s", text);
}

static void scan(const char *path, const char *text)
{
    const char *slash = strrchr(path, '/');
    char format[LONGEST + 8];
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        size_t length = strlen(calls[i]);
        for (const char *p = text; (p = strstr(p, calls[i])) != NULL; p += length) {
            bool whole = p == text || (!isalnum((unsigned char)p[-1]) && p[-1] != '_');
            const char *first = p + length + 1 + (p[length] ? strspn(p + length + 1, " \n") : 0);
            bool quiet = strcmp(calls[i], "kd_log") == 0 && strncmp(first, "KD_LOG_WARNING", 14) != 0 &&
                         strncmp(first, "KD_LOG_ERROR", 12) != 0;
            if (whole && p[length] == '(' && !quiet && format_of(p + length + 1, format))
                add(path, slash ? (size_t)(slash - path) : 0, format);
        }
    }
}

static int by_folder(const void *a, const void *b)
{
    const struct row *x = a, *y = b;
    int folder = strcmp(x->folder, y->folder);
    return folder ? folder : strcmp(x->text, y->text);
}

static void put_quoted(const char *text)
{
    putchar('"');
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            putchar('\\');
        putchar(*text);
    }
    putchar('"');
}

int main(int count, char **arguments)
{
    for (int i = 2; i < count; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", arguments[1], arguments[i]);
        char *text = read_file(path);
        if (!text)
            return fprintf(stderr, "%s cannot be read\n", path), 1;
        scan(arguments[i], text);
        free(text);
    }
    qsort(rows, row_count, sizeof *rows, by_folder);
    printf("#include \"runtime/app/help_files.h\"\n\nconst app_message_row app_messages[] = {\n");
    for (size_t i = 0; i < row_count; i++) {
        if (i && by_folder(&rows[i], &rows[i - 1]) == 0)
            continue;
        printf("    {");
        put_quoted(rows[i].folder);
        printf(", ");
        put_quoted(rows[i].text);
        printf("},\n");
    }
    printf("    {0, 0},\n};\n");
    return 0;
}
