/* The completion for zsh: commands with what they do, each command's options, words where an option takes one
 * of a few, and settings after --set. */

#include <stdio.h>
#include <string.h>

#include "runtime/app/help_files.h"
#include "runtime/app/options.h"
#include "runtime/core/settings.h"

/* Between single quotes, where brackets and colons mean something to _arguments and _describe. */
static void put_text(const char *text)
{
    for (; *text; text++) {
        if (*text == '\'')
            printf("'\\''");
        else if (strchr("[]:\\", *text))
            printf("\\%c", *text);
        else
            putchar(*text);
    }
}

static void put_words(const char *const *words)
{
    printf("(");
    for (size_t i = 0; words[i]; i++)
        printf("%s%s", i ? " " : "", words[i]);
    printf(")");
}

/* What follows an option: one of some words, a setting, or a file. */
static void put_value(const app_option_row *o)
{
    if (!o->value)
        return;
    printf(":");
    put_text(o->value);
    printf(":");
    if (strcmp(o->name, "--gi") == 0)
        put_words(app_gi_words);
    else if (strcmp(o->name, "--view") == 0)
        put_words(app_view_words);
    else if (strcmp(o->name, "--context") == 0)
        put_words(app_context_words);
    else
        printf(strcmp(o->name, "--set") == 0 ? "_kandil_settings" : "_files");
}

static void put_command(const app_command_row *row)
{
    printf("    %s) _arguments '--help[print the options]'", row->name);
    for (const app_option_row *o = app_command_options(row->command); o && o->name; o++) {
        printf(" \\\n        '*%s[", o->name);
        put_text(o->doc);
        printf("]");
        put_value(o);
        printf("'");
    }
    printf(" \\\n        '*:file:_files' ;;\n");
}

void app_zsh_completion_print(void)
{
    size_t count;
    const kd_setting_row *settings = kd_settings_rows(&count);
    printf("#compdef kandil\n# zsh completion for kandil; made by `kandil help zsh`\n"
           "_kandil_settings()\n{\n    compadd -S '' --");
    for (size_t i = 0; i < count; i++)
        printf(" \\\n        %s=", settings[i].key);
    printf("\n}\n_kandil()\n{\n    local -a commands=(");
    for (const app_command_row *row = app_commands; row->name; row++) {
        printf("\n        '%s:", row->name);
        put_text(row->doc);
        printf("'");
    }
    printf(")\n    if (( CURRENT == 2 )); then\n        _describe command commands\n        return\n    fi\n"
           "    local command=$words[2]\n    shift words\n    (( CURRENT-- ))\n    case $command in\n");
    for (const app_command_row *row = app_commands; row->name; row++)
        put_command(row);
    printf("    esac\n}\n_kandil \"$@\"\n");
}
