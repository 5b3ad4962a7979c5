/* Every public function of the ECS and of the jobs stands in an example of a chapter, and those are compiled
 * and run. A function is what a public header writes as kd_NAME( outside comments; names that end in _fn are
 * types. */

#include <ctype.h>
#include <glob.h>

#include "runtime/core/file.h"
#include "tests/unit/ecs_fixture.h"

static char *read_text(const char *path)
{
    void *data;
    size_t size;
    assert_int_equal(kd_file_read(path, 1 << 24, &data, &size), KD_OK);
    char *text = realloc(data, size + 1);
    assert_non_null(text);
    text[size] = 0;
    return text;
}

static void blank(char *from, const char *end)
{
    for (; from < end; from++)
        if (*from != '\n')
            *from = ' ';
}

static void blank_comments(char *text)
{
    for (char *at = text; (at = strchr(at, '/')); at++) {
        const char *end = at[1] == '*' ? strstr(at + 2, "*/") : at[1] == '/' ? strchr(at, '\n') : NULL;
        if (end)
            blank(at, at[1] == '*' ? end + 2 : end);
    }
}

/* Leave only the blocks of C in a chapter. */
static void blank_prose(char *text)
{
    bool inside = false;
    for (char *line = text; *line;) {
        char *next = strchr(line, '\n');
        next = next ? next + 1 : line + strlen(line);
        bool fence = strncmp(line, "```", 3) == 0;
        bool opens = !inside && fence && line[3] == 'c' && (line[4] == '\n' || line[4] == ' ');
        if (!inside || fence)
            blank(line, next);
        inside = fence ? opens : inside;
        line = next;
    }
}

static bool is_name(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

/* Does the text call NAME? */
static bool calls(const char *text, const char *name, size_t length)
{
    for (const char *at = text; (at = strstr(at, name)); at += length)
        if ((at == text || !is_name(at[-1])) && at[length] == '(')
            return true;
    return false;
}

/* Report each function of the header that no chapter calls; returns how many the header has. */
static int check_header(const char *path, char *const *chapters, int chapter_count, int *missing)
{
    char *text = read_text(path), name[128];
    int count = 0;
    blank_comments(text);
    for (char *at = text; (at = strstr(at, "kd_")); at += 3) {
        size_t length = 0;
        while (is_name(at[length]))
            length++;
        bool whole = at == text || !is_name(at[-1]), type = strncmp(at + length - 3, "_fn", 3) == 0;
        if (!whole || at[length] != '(' || type || length >= sizeof name)
            continue;
        memcpy(name, at, length);
        name[length] = 0;
        count++;
        bool found = false;
        for (int i = 0; i < chapter_count; i++)
            found |= calls(chapters[i], name, length);
        if (!found)
            print_error("%s: %s stands in no example of docs/ecs.md or docs/jobs.md\n", path, name);
        *missing += !found;
    }
    free(text);
    return count;
}

static bool is_public(const char *path)
{
    static const char *const internal[] = {"internal.h", "layout.h", "_format.h", "deque.h", "queue.h"};
    for (size_t i = 0; i < sizeof internal / sizeof *internal; i++)
        if (strlen(path) >= strlen(internal[i]) &&
            strcmp(path + strlen(path) - strlen(internal[i]), internal[i]) == 0)
            return false;
    return true;
}

static void every_public_function_stands_in_an_example(void **state)
{
    char *chapters[] = {read_text(KD_SOURCE_DIR "/docs/ecs.md"), read_text(KD_SOURCE_DIR "/docs/jobs.md")};
    glob_t headers = {0};
    int missing = 0, functions = 0;
    (void)state;
    blank_prose(chapters[0]);
    blank_prose(chapters[1]);
    assert_int_equal(glob(KD_SOURCE_DIR "/runtime/ecs/*.h", 0, NULL, &headers), 0);
    assert_int_equal(glob(KD_SOURCE_DIR "/runtime/jobs/*.h", GLOB_APPEND, NULL, &headers), 0);
    for (size_t i = 0; i < headers.gl_pathc; i++)
        if (is_public(headers.gl_pathv[i]))
            functions += check_header(headers.gl_pathv[i], chapters, 2, &missing);
    assert_true(functions > 100); /* the headers were read at all */
    assert_int_equal(missing, 0);
    globfree(&headers);
    free(chapters[0]);
    free(chapters[1]);
}

static void a_function_without_example_is_noticed(void **state)
{
    char chapter[] =
        "Call kd_prose(w) where\n\n```c\nkd_shown(w); /* kd_other_shown */\n```\nand kd_more(w).\n";
    (void)state;
    blank_prose(chapter);
    assert_true(calls(chapter, "kd_shown", 8));
    assert_false(calls(chapter, "kd_prose", 8));
    assert_false(calls(chapter, "kd_more", 7));
    assert_false(calls(chapter, "kd_show", 7));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_public_function_stands_in_an_example),
        cmocka_unit_test(a_function_without_example_is_noticed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
