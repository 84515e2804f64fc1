/* The logger of FMI 2.0 §2.1.5. It is variadic, which Rust can call but not define: this function
 * fills in the placeholders and hands the finished text on. The environment is the importer's own,
 * see `instance/host.rs`; its first member is the function that takes the line. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

struct environment {
    void (*line)(struct environment *, int status, const char *category, const char *text);
};

void fmi_import_logger(struct environment *environment, const char *name, int status,
                       const char *category, const char *format, ...)
{
    char brief[1024];
    char *text = brief;
    va_list arguments;
    int length;

    (void)name;
    if (environment == NULL)
        return;
    if (format == NULL)
        format = "";
    va_start(arguments, format);
    length = vsnprintf(brief, sizeof brief, format, arguments);
    va_end(arguments);
    if (length >= (int)sizeof brief) {
        char *whole = malloc((size_t)length + 1);
        /* without memory the line is cut */
        if (whole != NULL) {
            va_start(arguments, format);
            vsnprintf(whole, (size_t)length + 1, format, arguments);
            va_end(arguments);
            text = whole;
        }
    }
    /* what cannot be formatted is better than nothing */
    environment->line(environment, status, category, length < 0 ? format : text);
    if (text != brief)
        free(text);
}
