/* Help, generated from the tables that also parse the command line and hold the settings. */
#include "runtime/app/help.h"

#include <stdio.h>
#include <string.h>

#include "runtime/app/app.h"
#include "runtime/app/help_files.h"
#include "runtime/app/options.h"
#include "runtime/app/scene.h"
#include "runtime/app/world_setup.h"
#include "runtime/core/log.h"
#include "runtime/core/nearest.h"

static void print_program(void)
{
    printf("Kandil %s: animated scenes lit by their own voxels.\n\nusage: kandil COMMAND …\n\n", KD_VERSION);
    for (const app_command_row *row = app_commands; row->name; row++) {
        char left[64];
        snprintf(left, sizeof left, "%s %s", row->name, row->subject ? row->subject : "");
        printf("  %-20s %s\n", left, row->doc);
    }
    printf("  %-20s %s\n\n", "--version", "print the version");
    printf("`kandil help run` lists its options, `kandil help settings` what --set takes,\n"
           "`kandil help scenario` what scenarios can use.\n"
           "Exit codes: 0 done, 1 the work failed, 2 the command line is wrong, 130 interrupted.\n");
}

static void print_command(const app_command_row *row)
{
    const app_option_row *options = app_command_options(row->command);
    printf("usage: kandil %s%s%s%s\n\n%s\n", row->name, row->subject ? " " : "",
           row->subject ? row->subject : "", options ? " [OPTIONS]" : "", row->doc);
    if (row->command == APP_RUN)
        printf("\nA model that brings no camera or light is framed and lit; a small one without animation is "
               "turned.\n");
    if (row->command == APP_BENCH)
        printf("\nEach row: median, least and most of 9 or more samples, and the limit measured in the same "
               "run: plain arrays,\na plain copy, or the serial work divided by the threads. voxels and svo run a "
               "SCENE (default: the demo's).\n");
    if (options)
        printf("\n");
    for (const app_option_row *option = options; option && option->name; option++) {
        char left[64];
        snprintf(left, sizeof left, "%s %s", option->name, option->value ? option->value : "");
        printf("  %-24s %s\n", left, option->doc);
    }
}

static void print_choices(const kd_setting_row *row)
{
    if (row->words) {
        for (size_t i = 0; row->words[i]; i++)
            printf("%s%s", i ? "|" : "", row->words[i]);
    } else if (row->type == KD_SETTING_BOOL) {
        printf("on|off");
    } else {
        printf("%.10g … %.10g", row->min, row->max);
    }
    printf("%s%s", row->unit ? " " : "", row->unit ? row->unit : "");
}

static void print_settings(void)
{
    size_t count;
    const kd_setting_row *rows = kd_settings_rows(&count);
    kd_settings defaults = kd_settings_defaults();
    printf("usage: kandil run SCENE --set KEY=VALUE …\n\n");
    for (size_t i = 0; i < count; i++) {
        char text[32];
        printf("  %-24s %s (", rows[i].key, rows[i].doc);
        print_choices(&rows[i]);
        printf("; default %s)\n", kd_settings_format(&defaults, &rows[i], text, sizeof text));
    }
    printf("\nNAME.component.field=VALUE sets a field of the entity of that name, such as "
           "lamp.light.intensity=5.\n"
           "param.NAME=VALUE is what the scenario gets by kandil.param(\"NAME\", default).\n");
}

static bool may_write(void *user, const char *component, const char *field)
{
    (void)user;
    return app_may_write(component, field);
}

static kd_status print_reference(const kd_extension *extension)
{
    kd_world *w = kd_world_make();
    if (!w)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    app_register_components(w, extension);
    kd_script_write_reference(w, may_write, stdout);
    kd_world_destroy(w);
    return KD_OK;
}

kd_status app_help_print(const char *topic, const kd_extension *extension)
{
    if (!topic) {
        print_program();
        return KD_OK;
    }
    kd_nearest near = kd_nearest_to(topic);
    kd_nearest_offer(&near, "settings");
    kd_nearest_offer(&near, "scenario");
    kd_nearest_offer(&near, "man");
    kd_nearest_offer(&near, "messages");
    kd_nearest_offer(&near, "bash");
    kd_nearest_offer(&near, "zsh");
    if (strcmp(topic, "scenario") == 0)
        return print_reference(extension);
    if (strcmp(topic, "settings") == 0) {
        print_settings();
        return KD_OK;
    }
    if (strcmp(topic, "man") == 0) {
        app_manual_print();
        return KD_OK;
    }
    if (strcmp(topic, "messages") == 0) {
        app_messages_print();
        return KD_OK;
    }
    if (strcmp(topic, "bash") == 0) {
        app_completion_print();
        return KD_OK;
    }
    if (strcmp(topic, "zsh") == 0) {
        app_zsh_completion_print();
        return KD_OK;
    }
    for (const app_command_row *row = app_commands; row->name; row++) {
        if (strcmp(row->name, topic) == 0) {
            print_command(row);
            return KD_OK;
        }
        kd_nearest_offer(&near, row->name);
    }
    if (near.best)
        return kd_fail(KD_USAGE, "no help on '%s'; did you mean '%s'?", topic, near.best);
    return kd_fail(KD_USAGE, "no help on '%s'; `kandil help` lists the commands", topic);
}
