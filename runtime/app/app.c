/* Commands to functions, statuses to exit codes. Every failure has written one message by the time it gets
 * here; a status that came without one still gets a line. */
#include "runtime/app/app.h"

#include <stdio.h>

#include "runtime/app/bench.h"
#include "runtime/app/comparison.h"
#include "runtime/app/console.h"
#include "runtime/app/doctor.h"
#include "runtime/app/extension.h"
#include "runtime/app/help.h"
#include "runtime/app/info.h"
#include "runtime/app/options.h"
#include "runtime/app/run.h"
#include "runtime/app/tracing.h"
#include "runtime/app/voxelize.h"
#include "runtime/core/log.h"

static kd_status dispatch(const app_options *options)
{
    switch (options->command) {
    case APP_RUN: return app_run(options);
    case APP_REFERENCE: return app_reference_run(options);
    case APP_COMPARE: return app_compare_run(options);
    case APP_VOXELIZE: return app_voxelize(options);
    case APP_INFO: return app_info_print(options->subject);
    case APP_DOCTOR: return app_doctor_print();
    case APP_BENCH: return app_bench_run(options);
    case APP_VERSION: printf("kandil %s\n", KD_VERSION); return KD_OK;
    case APP_HELP: break;
    }
    return app_help_print(options->subject, options->extension);
}

static int exit_code(kd_status status)
{
    switch (status) {
    case KD_OK: return 0;
    case KD_USAGE: return 2;
    case KD_INTERRUPTED: return 130;
    default: return 1;
    }
}

int kd_main(int argc, char **argv, const kd_extension *extension)
{
    app_options options;
    app_console_open();
    kd_status status = app_options_parse(argc, argv, &options);
    if (status == KD_OK) {
        options.extension = extension;
        app_console_set_quiet(options.quiet);
        status = dispatch(&options);
        app_options_fini(&options);
    }
    if (fflush(stdout) != 0 && status == KD_OK)
        status = kd_fail(KD_IO, "standard output could not be written; check the disk or the pipe");
    if (status != KD_OK && status != KD_INTERRUPTED && !app_console_said_error())
        kd_log(KD_LOG_ERROR, "%s", kd_status_text(status));
    app_console_close();
    return exit_code(status);
}
