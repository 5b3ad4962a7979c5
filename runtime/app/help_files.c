#include "runtime/app/help_files.h"

#include <stdio.h>
#include <string.h>

#include "runtime/app/app.h"
#include "runtime/app/options.h"
#include "runtime/core/settings.h"

/* ---- the manual page ---- */

/* Text in which nothing is taken for a macro or an escape. */
static void put_roff(const char *text)
{
    if (*text == '.' || *text == '\'')
        fputs("\\&", stdout);
    for (; *text; text++) {
        if (*text == '\\')
            fputs("\\e", stdout);
        else if (*text == '-')
            fputs("\\-", stdout);
        else
            putchar(*text);
    }
}

/* A line in bold, with its value in italics, and what it means below. */
static void put_entry(const char *name, const char *value, const char *doc)
{
    fputs(".TP\n\\fB", stdout);
    put_roff(name);
    fputs("\\fR", stdout);
    if (value) {
        fputs(" \\fI", stdout);
        put_roff(value);
        fputs("\\fR", stdout);
    }
    putchar('\n');
    put_roff(doc);
    putchar('\n');
}

static void put_command(const app_command_row *row)
{
    printf(".SS ");
    put_roff(row->name);
    printf(" %s\n", row->subject ? row->subject : "");
    put_roff(row->doc);
    printf(".\n");
    for (const app_option_row *o = app_command_options(row->command); o && o->name; o++)
        put_entry(o->name, o->value, o->doc);
}

void app_manual_print(void)
{
    size_t count;
    const kd_setting_row *settings = kd_settings_rows(&count);
    printf(".TH KANDIL 1 \"\" \"Kandil %s\" \"User Commands\"\n", KD_VERSION);
    printf(
        ".SH NAME\nkandil \\- animated scenes lit by their own voxels\n"
        ".SH SYNOPSIS\n.B kandil\n.I COMMAND\n.RI [ OPTIONS ]\n"
        ".SH DESCRIPTION\nSkinned, rigid, morphing and subdivided objects, lights and cameras are "
        "entities of a scenario or a model file. Their voxels are brought into a sparse voxel octree every "
        "frame, and cones traced through it light the picture, in a window or without one, on a GPU or by "
        "Mesa's software driver.\n.SH COMMANDS\n");
    for (const app_command_row *row = app_commands; row->name; row++)
        put_command(row);
    printf(".SH SETTINGS\nGiven as \\fB\\-\\-set\\fR \\fIKEY=VALUE\\fR.\n");
    for (size_t i = 0; i < count; i++)
        put_entry(settings[i].key, NULL, settings[i].doc);
    printf(".SH ENVIRONMENT\n");
    put_entry("KANDIL_CACHE", NULL,
              "folder of the voxels kept for the next start; empty: none are kept. Default: kandil in "
              "XDG_CACHE_HOME");
    put_entry("KANDIL_SHADER_DIR", NULL, "folder with shaders/ to take instead of the built-in shaders");
    printf(".SH EXIT STATUS\n0 done, 1 the work failed, 2 the command line is wrong, 130 interrupted.\n");
}

/* ---- messages ---- */

void app_messages_print(void)
{
    const char *folder = "";
    printf("Messages have the form `kandil: FILE: what is wrong (where); what to do`; an ellipsis stands for what is\n"
           "filled in. They are listed by the part of the program that says them.\n");
    for (const app_message_row *row = app_messages; row->text; row++) {
        if (strcmp(row->folder, folder) != 0)
            printf("\n%s\n", row->folder);
        folder = row->folder;
        printf("  %s\n", row->text);
    }
}

/* ---- completion ---- */

static void put_options(app_command command)
{
    for (const app_option_row *o = app_command_options(command); o && o->name; o++)
        printf(" %s", o->name);
}

static void put_choices(const char *option, const char *const *words)
{
    printf("    %s) words=\"", option);
    for (size_t i = 0; words[i]; i++)
        printf("%s%s", i ? " " : "", words[i]);
    printf("\" ;;\n");
}

void app_completion_print(void)
{
    size_t count;
    const kd_setting_row *settings = kd_settings_rows(&count);
    printf("# bash completion for kandil; made by `kandil help bash`\n_kandil()\n{\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=\n"
           "    COMPREPLY=()\n"
           "    case $before in\n");
    put_choices("--gi", app_gi_words);
    put_choices("--view", app_view_words);
    put_choices("--context", app_context_words);
    printf("    --set) compopt -o nospace; words=\"");
    for (size_t i = 0; i < count; i++)
        printf("%s%s=", i ? " " : "", settings[i].key);
    printf("\" ;;\n    esac\n    if [ -z \"$words\" ] && [ \"$COMP_CWORD\" -eq 1 ]; then\n        "
           "words=\"--version");
    for (const app_command_row *row = app_commands; row->name; row++)
        printf(" %s", row->name);
    printf("\"\n    elif [ -z \"$words\" ]; then\n        case $word in -*) case ${COMP_WORDS[1]} in\n");
    for (const app_command_row *row = app_commands; row->name; row++) {
        printf("        %s) words=\"", row->name);
        put_options(row->command);
        printf(" --help\" ;;\n");
    }
    printf("        esac ;; esac\n    fi\n"
           "    if [ -n \"$words\" ]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
           "    else\n        compopt -o default\n    fi\n}\ncomplete -F _kandil kandil\n");
}
