#include "cli/settings.h"

#include <string.h>

static void append(cli_setting *settings, size_t *count, const char *flag, const char *key,
                   size_t length, const char *value) {
    cli_setting *setting = &settings[(*count)++];
    setting->flag = flag;
    memcpy(setting->key, key, length);
    setting->key[length] = '\0';
    setting->value = value;
}

static dl_status append_repeated(const char *text, const char *dt, const char *rtol,
                                 cli_setting *settings, size_t *count, dl_error *error) {
    const size_t length = strcspn(text, "=");
    if (length >= sizeof settings->key)
        return dl_fail(error, DL_INPUT, "--set: found \"%s\", expected KEY=VALUE", text);
    append(settings, count, "--set", text, length, text + length + 1);
    const char *key = settings[*count - 1].key;
    if ((dt && strcmp(key, "step") == 0) || (rtol && strcmp(key, "rtol") == 0))
        return dl_fail(error, DL_INPUT, "--set: found \"%s\", which --%s sets already", text,
                       strcmp(key, "step") == 0 ? "dt" : "rtol");
    return DL_OK;
}

dl_status cli_settings_read(const cli_input *input, const char *dt, const char *rtol,
                            cli_setting settings[CLI_MAX_SETTINGS], size_t *count,
                            dl_error *error) {
    *count = 0;
    if (dt)
        append(settings, count, "--dt", "step", strlen("step"), dt);
    if (rtol)
        append(settings, count, "--rtol", "rtol", strlen("rtol"), rtol);
    dl_status status = DL_OK;
    for (size_t i = 0; i < input->repeats && !status; i++)
        status = append_repeated(input->repeated[i], dt, rtol, settings, count, error);
    return status;
}

void cli_name_option(const char *key, const char *option, dl_error *error) {
    char text[DL_MESSAGE_SIZE];
    const size_t length = strlen(key);
    if (strncmp(error->message, key, length) != 0)
        return;
    memcpy(text, error->message, sizeof text);
    dl_fail(error, DL_INPUT, "%s%s", option, text + length);
}

dl_status cli_settings_method(const char *method, dl_error *error) {
    return method ? DL_OK
                  : dl_fail(error, DL_INPUT,
                            "--method: found none, expected a method's name (driftlab list "
                            "methods)");
}
