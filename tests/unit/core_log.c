/* Messages, statuses and the clock. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"

static char caught[2048];
static void catch_message(void *user, kd_log_level level, const char *text)
{
    *(kd_log_level *)user = level;
    strncpy(caught, text, sizeof caught - 1);
}

static void fail_logs_whole_message_and_returns_status(void **state)
{
    (void)state;
    kd_log_level level = KD_LOG_DEBUG;
    char longer[1500];
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    kd_log_set_sink(catch_message, &level);
    int errors = kd_log_count(KD_LOG_ERROR), warnings = kd_log_count(KD_LOG_WARNING);
    assert_int_equal(kd_fail(KD_BAD_FORMAT, "%s!", longer), KD_BAD_FORMAT);
    assert_int_equal(level, KD_LOG_ERROR);
    assert_int_equal(strlen(caught), 1500);
    assert_int_equal(caught[1499], '!');
    kd_log(KD_LOG_WARNING, "w");
    assert_int_equal(kd_log_count(KD_LOG_ERROR), errors + 1);
    assert_int_equal(kd_log_count(KD_LOG_WARNING), warnings + 1);
    kd_log_set_sink(NULL, NULL);
}

static void every_status_has_a_text(void **state)
{
    (void)state;
    for (int s = 0; s < KD_STATUS_COUNT; s++)
        assert_true(strlen(kd_status_text((kd_status)s)) > 3);
    assert_non_null(kd_status_text((kd_status)999));
    assert_string_equal(kd_status_text(KD_DISK_FULL), "no space left on the disk");
}

static void clock_never_goes_back(void **state)
{
    (void)state;
    uint64_t last = kd_clock_ns();
    for (int i = 0; i < 10000; i++) {
        uint64_t now = kd_clock_ns();
        assert_true(now >= last);
        last = now;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fail_logs_whole_message_and_returns_status),
        cmocka_unit_test(every_status_has_a_text),
        cmocka_unit_test(clock_never_goes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
