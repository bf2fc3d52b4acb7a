use nextview_scan::Fault;
use subtle::ConstantTimeEq;

/// A secret that shows who asks.
pub(crate) struct Token(String);

/// Fewest characters of a token that somebody chose.
const LEAST: usize = 16;

impl Token {
    /// 256 random bits.
    pub fn random() -> Result<Self, Fault> {
        Ok(Self(random_hex(32)?))
    }

    /// One that was chosen: at least 16 visible ASCII characters, without white space around them.
    pub fn chosen(text: &str) -> Result<Self, Fault> {
        let text = text.trim();
        if text.len() < LEAST || !text.bytes().all(|byte| byte.is_ascii_graphic()) {
            let message = format!("the token must have at least {LEAST} visible ASCII characters");
            return Err(
                Fault::request(message).with_remedy("make one, for example with `openssl rand -hex 32`")
            );
        }
        Ok(Self(text.to_owned()))
    }

    /// Whether somebody else has the same, in a time that does not depend on how much of it is right.
    pub fn is(&self, other: &[u8]) -> bool {
        self.0.as_bytes().ct_eq(other).into()
    }

    /// To be told to whom it is for.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

/// So many random bytes, as hexadecimal digits.
pub(crate) fn random_hex(n_bytes: usize) -> Result<String, Fault> {
    let mut bytes = vec![0; n_bytes];
    getrandom::fill(&mut bytes)
        .map_err(|error| Fault::data(format!("the system has no random numbers: {error}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
