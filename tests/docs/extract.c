/* Make a test of the examples of a chapter: extract CHAPTER.md OUT.c. Blocks fenced with ```c file are copied
 * as they are; each block fenced with ```c becomes a test of its own, in which `w` is a fresh world and
 * `jobs` a pool of two threads. #line keeps messages of the compiler and of assert() at the chapter's lines.
 */
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { MAX_EXAMPLES = 256, MAX_LINE = 1024 };

static const char head[] = "#include <setjmp.h>\n"
                           "#include <stdarg.h>\n"
                           "#include <stddef.h>\n"
                           "#include <stdint.h>\n"
                           "#include <cmocka.h>\n"
                           "#include <assert.h>\n"
                           "#include <stdatomic.h>\n"
                           "#include <stdio.h>\n"
                           "#include <stdlib.h>\n"
                           "#include <string.h>\n"
                           "#include \"runtime/ecs/instance.h\"\n"
                           "#include \"runtime/ecs/observer.h\"\n"
                           "#include \"runtime/ecs/path.h\"\n"
                           "#include \"runtime/ecs/query.h\"\n"
                           "#include \"runtime/ecs/reflect.h\"\n"
                           "#include \"runtime/ecs/relation.h\"\n"
                           "#include \"runtime/ecs/snapshot.h\"\n"
                           "#include \"runtime/ecs/statistics.h\"\n"
                           "#include \"runtime/ecs/system.h\"\n"
                           "#include \"runtime/ecs/validate.h\"\n"
                           "#include \"runtime/jobs/graph.h\"\n";

static void begin_example(FILE *out, const char *chapter, int line)
{
    fprintf(out,
            "static void example_at_line_%d(void **state) {\n"
            "    kd_world *w = kd_world_make();\n"
            "    kd_jobs *jobs = kd_jobs_make(2);\n"
            "    (void)state;\n"
            "    assert(w && jobs);\n"
            "    {\n"
            "#line %d \"%s\"\n",
            line, line + 1, chapter);
}

static void end_example(FILE *out)
{
    fputs("    }\n    kd_world_destroy(w);\n    kd_jobs_destroy(jobs);\n}\n", out);
}

static void write_main(FILE *out, const int *lines, int count)
{
    fputs("int main(void) {\n    const struct CMUnitTest tests[] = {\n", out);
    for (int i = 0; i < count; i++)
        fprintf(out, "        cmocka_unit_test(example_at_line_%d),\n", lines[i]);
    fputs("    };\n    return cmocka_run_group_tests(tests, NULL, NULL);\n}\n", out);
}

/* Returns false when the chapter has no example or a block does not end. */
static bool extract(FILE *in, FILE *out, const char *chapter)
{
    enum { TEXT, EXAMPLE, FILE_SCOPE, OTHER } inside = TEXT;
    char line[MAX_LINE];
    int lines[MAX_EXAMPLES], count = 0;
    fputs(head, out);
    for (int number = 1; fgets(line, sizeof line, in); number++) {
        bool fence = strncmp(line, "```", 3) == 0;
        if (fence && inside == TEXT) {
            inside = strcmp(line, "```c\n") == 0        ? EXAMPLE
                     : strcmp(line, "```c file\n") == 0 ? FILE_SCOPE
                                                        : OTHER;
            if (inside == FILE_SCOPE)
                fprintf(out, "#line %d \"%s\"\n", number + 1, chapter);
            if (inside == EXAMPLE && count < MAX_EXAMPLES)
                begin_example(out, chapter, lines[count++] = number);
        } else if (fence) {
            if (inside == EXAMPLE)
                end_example(out);
            inside = TEXT;
        } else if (inside == EXAMPLE || inside == FILE_SCOPE) {
            fputs(line, out);
        }
    }
    write_main(out, lines, count);
    return inside == TEXT && count > 0 && count < MAX_EXAMPLES;
}

int main(int argc, char **argv)
{
    FILE *in = argc == 3 ? fopen(argv[1], "r") : NULL, *out = in ? fopen(argv[2], "w") : NULL;
    bool ok = out && extract(in, out, argv[1]);
    if (in)
        fclose(in);
    if (out)
        ok = fclose(out) == 0 && ok;
    if (!ok)
        fprintf(stderr, "extract: no examples could be taken from %s\n", argc > 1 ? argv[1] : "nothing");
    return ok ? 0 : 1;
}
