use quote::ToTokens;

/// Syntax as text, spaced as people write it.
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
