use quote::ToTokens;

/// Syntax as text, with conventional spacing.
pub(crate) fn text(tokens: &impl ToTokens) -> String {
    let mut text = tokens.to_token_stream().to_string();
    for (tokens, written) in [
        (" :: ", "::"),
        (":: ", "::"),
        (" : ", ": "),
        (" , ", ", "),
        (" ;", ";"),
        (" ( ", "("),
        ("( ", "("),
        (" (", "("),
        (" )", ")"),
        (" [ ", " ["),
        ("[ ", "["),
        (" ]", "]"),
        ("& ", "&"),
        (" < ", "<"),
        ("< ", "<"),
        (" <", "<"),
        (" >", ">"),
        ("' ", "'"),
        ("* ", "*"),
        (" ?", "?"),
        (" !", "!"),
        ("# ", "#"),
        ("->", " ->"),
        (" - >", " ->"),
        ("  ", " "),
    ] {
        text = text.replace(tokens, written);
    }
    let text = text.replace(",)", ")").replace("->(", "-> (").replace("=(", "= (");
    text.replace("for(", "for (").trim().to_owned()
}
