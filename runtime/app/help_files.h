#ifndef KD_APP_HELP_FILES_H
#define KD_APP_HELP_FILES_H

/* What is installed beside the program, made from the tables that parse the command line. */

/** Print the manual page, in man(7) macros, to standard output. */
void app_manual_print(void);

/* What the program may say when something goes wrong, collected from its sources when it is built. */
typedef struct app_message_row {
    const char *folder; /* of the sources that say it */
    const char *text;   /* an ellipsis stands for what is filled in */
} app_message_row;
extern const app_message_row app_messages[]; /* by folder, ended by an empty row */

/** Print all of them to standard output. */
void app_messages_print(void);

/** Print the completion script for bash to standard output. */
void app_completion_print(void);
/** The same for zsh. */
void app_zsh_completion_print(void);

#endif
